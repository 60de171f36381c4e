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


VARIED = """# seoro: world office
import osc.worlds

scenario main:
    robot: differential_drive_robot
    width: length with:
        keep(it in [1m..1.3m])
    do serial:
        load_world_with('office?generate.rooms.corridor=2.0', \\
            counts: [count_setting('generate.rooms.count', 3)], \\
            lengths: [length_setting('generate.rooms.door', width), length_setting('wall_height', 80cm)], \\
            masses: [mass_setting('generate.clutter.mass', 0.5kg)], \\
            numbers: [number_setting('floor.friction', 0.8)])
        robot.init_at('room_3')
        LAST
"""


@pytest.mark.engine("mujoco")
@pytest.mark.parametrize(
    ("last", "words"),
    [
        ("robot.init_at('room_4')", "unknown pose 'room_4' of the world"),
        (
            "load_world_with('office', counts: [count_setting('generate.rooms.count', 300)])",
            "generate.rooms.count: Input should be less than or equal to 40",
        ),
        (
            "load_world_with('office', numbers: [number_setting('a', 1.0), number_setting('a', 2.0)])",
            "duplicate key 'a' of a world; expected one value for each key",
        ),
        (
            "load_world_with('office', switches: [switch_setting('a&b=1', true)])",
            "invalid parameter `a%26b%3D1=true`",
        ),
        ("load_world_with('office', lengths: [length_setting('attic', 1m)])", "attic"),
    ],
)
def test_keys_of_worlds_vary(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str, last: str, words: str
) -> None:
    file = tmp_path / "varied.osc"
    file.write_text(VARIED.replace("LAST", last))
    assert main(["exec", str(file), "--connect", mujoco_node, "--rate", "max", "--seed", "1"]) == 1
    captured = capsys.readouterr()
    assert words in captured.err
    assert "init_at  succeeded" in captured.out
