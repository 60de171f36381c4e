"""The published navigation scenarios, in MuJoCo unless another engine is named."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest

from seoro.cli.main import main
from tests.integration.conftest import GO_TO_POSE, OBSTACLE, read_trace

pytestmark = pytest.mark.engine("mujoco")


def run(
    scenario: str, folder: Path, seed: int, *arguments: str, simulator: str = "mujoco", node: str = ""
) -> list[dict[str, Any]]:
    used = ["--connect", node] if node else ["--sim", simulator]
    status = main([
        "exec", scenario, *used, "--rate", "max", "--seed", str(seed), "-o", str(folder), *arguments
    ])  # fmt: skip
    records = read_trace(folder / "trace.jsonl")
    assert status == 0, records[-1]
    return records


@pytest.mark.slow
def test_the_robot_goes_around_the_box(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    records = run(OBSTACLE, tmp_path, 0)
    assert records[-1]["duration"] < 60.0
    assert [r for r in records if r["kind"] == "event" and r["name"] == "contact"] == []
    names = {r["id"]: r["name"] for r in records if r["kind"] == "behavior.start"}
    ended = {names[r["id"]]: r["t"] for r in records if r["kind"] == "behavior.end" and r["status"] == "succeeded"}
    assert 0.0 < ended["box.spawn"] < ended["robot.nav_to_pose"]
    assert (tmp_path / "top_down.png").read_bytes().startswith(b"\x89PNG")
    assert Xml.parse(tmp_path / "test.xml").find(".//testcase") is not None
    out = capsys.readouterr().out
    for name in ("trace.jsonl", "test.xml", "top_down.png"):
        assert str(tmp_path / name) in out


@pytest.mark.slow  # the catalogue has the same scenario in the suite
def test_the_robot_goes_around_the_box_in_pybullet(tmp_path: Path) -> None:
    pytest.importorskip("pybullet", reason="the engine pybullet is not installed")
    first, second = (run(OBSTACLE, tmp_path / name, 0, simulator="pybullet") for name in ("first", "second"))
    assert first[-1]["duration"] < 60.0
    assert [r for r in first if r["kind"] == "event" and r["name"] == "contact"] == []
    assert [{**r, "wall": 0} for r in first] == [{**r, "wall": 0} for r in second]
    assert (tmp_path / "first" / "top_down.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow  # the same
def test_the_simple_navigation_scenario_passes(tmp_path: Path) -> None:
    assert run(GO_TO_POSE, tmp_path, 3)[-1]["duration"] < 60.0


@pytest.mark.slow
def test_traces_are_equal_for_equal_seeds_only(tmp_path: Path) -> None:
    first, second, other = (
        [{key: value for key, value in record.items() if key != "wall"} for record in records]
        for records in (run(OBSTACLE, tmp_path / name, seed) for name, seed in (("a", 5), ("b", 5), ("c", 8)))
    )
    assert first == second
    assert first[-1]["t"] != other[-1]["t"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_every_seed_passes_without_contacts(tmp_path: Path, seed: int) -> None:
    records = run(OBSTACLE, tmp_path, seed)
    assert records[-1]["duration"] < 60.0
    assert [r for r in records if r["kind"] == "event" and r["name"] == "contact"] == []


def test_a_goal_inside_a_wall_fails_with_its_position(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str
) -> None:
    text = Path(OBSTACLE).read_text().replace("x: 3.0m, y: -3.0m", "x: 0.75m, y: 0.0m")
    file = tmp_path / "wall.osc"
    file.write_text(text)
    arguments = ["--connect", mujoco_node, "--world", "maze", "--rate", "max", "-o", str(tmp_path)]
    assert main(["exec", str(file), *arguments]) == 1
    assert (tmp_path / "top_down.png").exists()
    err = capsys.readouterr().err
    assert "goal (0.75, 0.00)" in err
    assert f"{file}:15:17" in err


def test_an_unknown_model_fails_with_the_searched_folders(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "model.osc"
    file.write_text(
        "import osc.gazebo\n"
        "scenario main:\n"
        "    box: sim_object\n"
        "    do box.spawn(pose_3d(position_3d(x: 1m, z: 0.2m)), 'shop://box.sdf')\n"
    )
    assert main(["exec", str(file), "--sim", "mujoco", "--rate", "max", "--model-path", str(tmp_path)]) == 1
    err = capsys.readouterr().err
    assert f"(searched: {tmp_path}/shop/box.sdf" in err


def test_an_action_without_a_simulator_is_refused_before_the_run(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", OBSTACLE, "--clock", "real"]) == 2
    err = capsys.readouterr().err
    assert f"{OBSTACLE}:13:13" in err
    assert "--sim mujoco" in err


def test_an_unknown_world_is_refused_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", OBSTACLE, "--sim", "mujoco", "--world", "castle"]) == 2
    assert "maze" in capsys.readouterr().err


def test_contacts_are_in_the_trace(tmp_path: Path, mujoco_node: str) -> None:
    """The check that finds no contacts in the runs above finds the contact of a dropped robot."""
    file = tmp_path / "drop.osc"
    file.write_text(
        "import osc.ros\n"
        "import osc.sim\n"
        "scenario main:\n"
        "    do serial:\n"
        "        spawn_entity('box', 'example_simulation://models/box.sdf',"
        " pose_3d(position_3d(x: 0.0m, y: 0.0m, z: 1.5m)))\n"
        "        wait elapsed(3s)\n"
    )
    records = run(str(file), tmp_path, 0, "--world", "empty", node=mujoco_node)
    contacts = [r for r in records if r["kind"] == "event" and r["name"] == "contact"]
    assert {"box", "turtlebot4"} == {contacts[0]["arguments"]["first"], contacts[0]["arguments"]["second"]}
    assert [each["t"] for each in contacts] == [each["arguments"]["time"] for each in contacts]


def test_simulator_actions_and_other_driving_actions_succeed(tmp_path: Path, mujoco_node: str) -> None:
    file = tmp_path / "all.osc"
    file.write_text(
        """
import osc.sim
import osc.gazebo
import osc.ros

scenario main:
    robot: differential_drive_robot
    pot: sim_object
    do serial:
        robot.init_nav2(pose_3d())
        spawn_entity('box', 'example_simulation://models/box.sdf', pose_3d(position_3d(x: 3m, y: 1m, z: 0.2m)))
        set_entity_state('box', pose_3d(position_3d(x: 3m, y: 2m, z: 0.2m)))
        pot.relative_spawn(distance: 2m, model: 'example_simulation://models/box.sdf')
        actor_exists('pot')
        step_simulation(250)
        parallel:
            robot.follow_waypoints([pose_3d(position_3d(x: 0.4m)), pose_3d(position_3d(x: 0.4m, y: 0.4m))])
            robot.odometry_distance_traveled(0.3m)
        robot.nav_through_poses([pose_3d(position_3d(x: 0.2m, y: 0.8m)), pose_3d(position_3d(y: 1m))])
        delete_entity('box')
        reset_simulation()
        wait elapsed(1s)
"""
    )
    records = run(str(file), tmp_path, 0, "--world", "empty", node=mujoco_node)
    ended = [r for r in records if r["kind"] == "behavior.end"]
    assert {r["status"] for r in ended} == {"succeeded"}


@pytest.mark.slow
def test_a_goal_without_a_client_is_replaced_by_the_next(tmp_path: Path) -> None:
    file = tmp_path / "left.osc"
    file.write_text(
        """import osc.nav2
import osc.driving
import osc.helpers
scenario main:
    turtlebot4: differential_drive_robot
    do serial:
        turtlebot4.init_nav2(pose_3d())
        turtlebot4.nav_to_pose(pose_3d(position_3d(x: 2m)), success_on_acceptance: true)
        wait elapsed(1s)
        turtlebot4.nav_to_pose(pose_3d(position_3d(x: -2m)), success_on_acceptance: true)
        turtlebot4.drive(0.1mps, 0radps, 0.5s)
        turtlebot4.nav_to_pose(pose_3d())
"""
    )
    records = run(str(file), tmp_path, 0, "--world", "empty")
    assert {r["status"] for r in records if r["kind"] == "behavior.end"} == {"succeeded"}


def test_an_unknown_entity_fails_with_the_known_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str
) -> None:
    file = tmp_path / "missing.osc"
    file.write_text("import osc.gazebo\nscenario main:\n    do actor_exists('box')\n")
    assert main(["exec", str(file), "--connect", mujoco_node, "--world", "maze", "--rate", "max"]) == 1
    assert "unknown entity 'box' (entities: turtlebot4, walls)" in capsys.readouterr().err


def test_a_parameter_for_ros_robots_is_refused_in_a_simulator(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str
) -> None:
    text = Path(GO_TO_POSE).read_text().replace("y: -3.0m))", "y: -3.0m)), namespace_override: 'r2'")
    file = tmp_path / "ros.osc"
    file.write_text(text)
    assert main(["exec", str(file), "--connect", mujoco_node, "--world", "maze", "--rate", "max"]) == 1
    assert "`namespace_override` cannot be set in a scenario; omit it" in capsys.readouterr().err
