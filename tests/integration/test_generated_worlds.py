"""Generated worlds with parameters, and `osc.worlds`, on simulator nodes."""

from pathlib import Path

import pytest

from seoro.cli.main import main

SCENARIO = """# seoro: world office?generate.rooms.corridor=2.0&generate.clutter.fixed=0
import osc.worlds

scenario main:
    robot: differential_drive_robot
    do serial:
        robot.init_at('start')
        robot.nav_to_place('start')
        robot.nav_to_place('attic')
"""


@pytest.mark.engine("mujoco")
def test_named_poses_of_a_generated_world_are_goals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "office.osc"
    file.write_text(SCENARIO)
    assert main(["exec", str(file), "--sim", "mujoco", "--rate", "max", "--seed", "1"]) == 1
    captured = capsys.readouterr()
    assert "unknown pose 'attic' of the world (poses: start, goal, room_1" in captured.err
    assert "nav_to_place  succeeded" in captured.out
