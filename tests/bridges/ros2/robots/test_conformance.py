"""The bridge to ROS 2 robots keeps the rules of its level."""

from __future__ import annotations

import json
from typing import Any

import pytest

from seoro.bridges.conformance import bridges
from seoro.cli.main import main
from tests.bridges.ros2.robots.conftest import Bridged


def test_the_bridge_keeps_the_rules_of_drives(bridged: Bridged, capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["check-node", bridged.endpoint, "--robot", "tb", "--level", "drive", "--yes", "--json"])
    result: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert [each for each in result["rules"] if not each["holds"]] == []
    assert (status, result["node"]) == (0, "bridge 'ros2'")
    assert max(velocity for _, velocity in bridged.notes("velocity")) == pytest.approx(bridges.SPEED)
