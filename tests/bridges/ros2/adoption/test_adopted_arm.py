"""An arm of an exposed simulator, adopted and moved by the written files."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.routers import free_endpoint, process
from tests.sim_nodes.engines import make_engine

SCENARIO = """
import osc.helpers
import osc.manipulation

scenario arm:
    timeout(60s)
    ur10e: manipulator
    do serial:
        ur10e.move_to_joint_pose([0.3, -1.4, 1.5, -1.6, -1.5, 0.0], move_group_type!arm)
        ur10e.release()
"""


@pytest.mark.more
def test_an_adopted_arm_moves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for limit in ("START_TIMEOUT", "MESSAGE_TIMEOUT"):  # the simulator is starting
        monkeypatch.setattr(f"seoro.bridges.ros2.adoption.survey.{limit}", 60.0)
    make_engine("mujoco")
    seoro = ("-m", "seoro")
    simulator, router, bridge = (free_endpoint() for _ in range(3))
    simulating = ("sim", "mujoco", "--world", "arm_cell", "--rate", "1", "--listen", simulator)
    exposing = ("bridge", "ros2", "--expose", "--simulator", simulator, "--ros-listen", router)
    robot = f"{tmp_path}/ur10e.yaml:ur10e@/ur10e"
    bridging = ("bridge", "ros2", "--robot", robot, "--ros", router, "--listen", bridge)
    file = tmp_path / "arm.osc"
    file.write_text(SCENARIO)
    with process(*seoro, *simulating, says=None), process(*seoro, *exposing, says=None):
        assert main(["ros", "adopt", "--ros", router, "--bridge", bridge, "-o", str(tmp_path), "--yes"]) == 0
        assert "tool: tcp\n" in (tmp_path / "ur10e.yaml").read_text()
        with process(*seoro, *bridging, says=None):
            assert main(["exec", str(file), "--lab", str(tmp_path / "lab.yaml")]) == 0
