"""`seoro check-node` of bridges."""

from __future__ import annotations

import json
from typing import Any

import pytest

from seoro.bridges import conformance
from seoro.bridges.conformance import BRIDGE_LEVELS, HeldRobot, bridges, check_bridge_rule
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.cli.main import main
from tests.bridges.robot.conftest import Rails


def test_a_bridge_holds_without_a_motion(rails: Rails, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-node", rails.endpoint, "--robot", "line"]) == 0, capsys.readouterr().out
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "bridge 'rails', level `hold`:"
    assert lines[-1] == "0 of 3 rules broken: conforms to level `hold`"
    assert {velocity for _, _, velocity in rails.commands()} == {0.0}


def test_a_bridge_drives(rails: Rails, capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["check-node", rails.endpoint, "--robot", "line", "--level", "drive", "--yes", "--json"])
    result: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert [each for each in result["rules"] if not each["holds"]] == []
    assert (status, len(result["rules"])) == (0, len(BRIDGE_LEVELS["drive"]))
    assert {velocity for _, _, velocity in rails.commands()} == {0.0, bridges.SPEED}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            ("--robot", "line", "--level", "time"),
            "invalid `--level time` of a bridge; expected hold, drive, navigate, arm",
        ),
        (("--level", "hold"), "`--level hold` is a level of bridges; expected `--robot` as well"),
        (("--level", "time", "--yes"), "`--yes` is for bridges; expected `--robot` as well"),
        (("--robot", "line", "--level", "drive"), "moving line needs a confirmation"),
        (("--robot", "train"), "unknown robot 'train'"),
        (("--robot", "line", "--world", "maze"), "`--world` applies to simulators"),
    ],
)
def test_options_that_do_not_fit_are_refused(
    rails: Rails, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], words: str
) -> None:
    assert main(["check-node", rails.endpoint, *options]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.anyio
async def test_a_bridge_without_cancellation_is_found(rails: Rails, monkeypatch: pytest.MonkeyPatch) -> None:
    async def ignore(self: RobotNode, goal: str) -> None:
        """Leave the goal alone."""

    monkeypatch.setattr(RobotNode, "cancel_goal", ignore)
    async with connect_robots(rails.endpoint, "a test") as node:
        with pytest.raises(conformance.BrokenRule, match="A cancelled drive does not succeed"):
            await check_bridge_rule(bridges.cancelled_drives_end, HeldRobot(node, "line", rails.endpoint))
