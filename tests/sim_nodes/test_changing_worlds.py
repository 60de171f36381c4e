"""Changes of the world during a run."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.simulator import Simulator
from tests.sim_nodes.client import ROBOT, TRUTH, Client, pose

KIND = "differential_drive_robot"
ROBOTS = "robots:\n  - {name: turtlebot4, robot: turtlebot4}\n"
IN_THE_WAY = "props:\n  - {name: block, cube: 0.3, mass: 1.0, pose: {x: 0.1, y: 0.0}}\n"


def change(client: Client, world: str, **robots: str) -> wire.SimulatorFeatures:
    return client.ask(wire.CHANGE_WORLD, wire.ChangeWorld(world=world, robots=robots or {ROBOT: KIND}))


def names(client: Client) -> tuple[str, ...]:
    return client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names


def world(client: Client) -> tuple[str, str]:
    current = client.ask(wire.GET_CURRENT_WORLD, wire.Empty())
    return current.name, current.source


def yard(folder: Path, body: str) -> str:
    path = folder / "yard.yaml"
    path.write_text(f"name: yard\nextent: [-5, -5, 5, 5]\n{body}")
    return str(path)


@pytest.fixture
def driving(empty: Client) -> Client:
    """Return a client of a robot on its way to a goal, with a box behind it."""
    empty.localise()
    empty.navigate(pose(3.0, 0.0))
    empty.spawn("box", pose(-2.0, 0.0))
    empty.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id="begun", robot=ROBOT, distance=0.1))
    empty.run_until("begun")
    return empty


def test_a_world_change_keeps_the_clock_and_starts_the_world(driving: Client) -> None:
    before = driving.simulator.time
    features = change(driving, "hall")
    assert (features.world, features.time) == ("hall", before)
    assert [robot.name for robot in features.robots] == [ROBOT, "second"]
    assert "box" not in names(driving)
    assert driving.truth.x == pytest.approx(-4.0, abs=1e-6)
    assert not driving.simulator.simulation.robot(ROBOT).mobile.localised_pose()
    assert world(driving) == ("hall", "hall")
    assert driving.advance(before).time == before
    assert driving.advance(before + 0.5).time == pytest.approx(before + 0.5)


@pytest.mark.parametrize("engine", ["mujoco", pytest.param("pybullet", marks=pytest.mark.slow)])
def test_a_changed_world_continues_with_the_same_seed(engine: str) -> None:
    later = Client("empty", 3, engine)
    later.advance(1.0)
    change(later, "hall")
    first = Client("hall", 3, engine)
    for client in (later, first):
        client.localise(pose(-4.0, 0.0))
        client.navigate(pose(-3.6, 0.2))
    ended, _ = first.run_until("goal")
    ended_later, _ = later.run_until("goal")
    assert ended_later.time == pytest.approx(ended.time + 1.0)
    assert later.truth == first.truth


def test_a_world_change_cancels_goals_and_frees_their_ids(driving: Client) -> None:
    before = driving.simulator.time
    change(driving, "hall")
    advanced = driving.advance(before + 1.0)
    assert (advanced.time, [(each.id, each.outcome) for each in advanced.occurrences]) == (
        before,
        [("goal", Outcome.CANCELED)],
    )
    driving.localise(pose(-4.0, 0.0))
    driving.navigate(pose(-3.5, 0.0))


def test_a_world_change_keeps_watches(driving: Client) -> None:
    driving.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id="way", robot=ROBOT, distance=0.4))
    driving.ask(
        wire.WATCH_RANGE, wire.WatchRange(id="near", robot=ROBOT, sensor="lidar", distance=0.2, start=0, end=0)
    )
    driving.watch(-3.8, 0.0, 0.1, TRUTH, watch="there")
    driving.watch(5.0, 5.0, 0.1, "box", watch="gone")
    driving.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="goal"))
    driving.advance(driving.simulator.time)
    change(driving, "hall")
    driving.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.0, duration=3.0))
    reported = []
    while "drive" not in reported:
        reported += [occurrence.id for occurrence in driving.advance(60.0).occurrences]
    assert reported == ["there", "way", "drive"]
    assert driving.simulator.simulation.robots_in_use == {ROBOT}  # keeps the lidar active


def test_a_world_without_a_robot_of_the_run_is_refused_and_nothing_changes(
    driving: Client, tmp_path: Path
) -> None:
    before = driving.truth
    for world, words in (
        (
            "arm_cell",
            "the world arm_cell, which lacks the differential_drive_robot 'turtlebot4'; robots: ur10e",
        ),
        (yard(tmp_path, "robots:\n  - {name: turtlebot4, robot: ur10e}\n"), r"robots: turtlebot4 \(manipulator\)"),
        ("moon", "unknown world 'moon'"),
    ):
        with pytest.raises(RequestRefused, match=words):
            change(driving, world)
    with pytest.raises(RequestRefused, match="lacks the arm 'second'"):
        change(driving, "maze", second="arm")
    assert driving.truth == before
    assert driving.simulator.simulation.robots_in_use == {ROBOT}


def test_a_world_without_a_busy_robot_is_refused(driving: Client, tmp_path: Path) -> None:
    with pytest.raises(RequestRefused, match="lacks the differential_drive_robot 'turtlebot4'"):
        driving.ask(wire.CHANGE_WORLD, wire.ChangeWorld(world=yard(tmp_path, ""), robots={}))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_world_refused_by_the_engine_changes_nothing(engine: str, tmp_path: Path) -> None:
    client = Client("empty", 3, engine)
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.0, duration=2.0))
    client.advance(1.0)
    with pytest.raises(RequestRefused, match="overlaps"):
        change(client, yard(tmp_path, ROBOTS + IN_THE_WAY))
    assert client.simulator.time == 1.0
    ended, _ = client.run_until("drive")
    undisturbed = Client("empty", 3, engine)
    undisturbed.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.0, duration=2.0))
    assert undisturbed.run_until("drive")[0] == ended
    assert client.truth == undisturbed.truth


def test_an_engine_without_snapshots_restarts_its_world_after_a_refusal(
    driving: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Simulator, "_contents", lambda _: None)
    before = driving.simulator.time
    with pytest.raises(RequestRefused, match="overlaps"):
        change(driving, yard(tmp_path, ROBOTS + IN_THE_WAY))
    reported = driving.advance(before + 1.0)
    assert (reported.time, [each.outcome for each in reported.occurrences]) == (before, [Outcome.CANCELED])
    assert driving.truth.x == pytest.approx(0.0, abs=1e-6)
    assert names(driving) == (ROBOT,)


def test_a_later_run_starts_in_the_world_of_the_node(driving: Client) -> None:
    change(driving, "hall")
    assert driving.ask(wire.LOAD_WORLD, wire.LoadWorld(world="", seed=0)).world == "empty"


def test_rewinding_returns_to_the_previous_world(driving: Client) -> None:
    place, snapshot = driving.truth, driving.ask(wire.SAVE_STATE, wire.Empty())
    change(driving, "hall")
    driving.advance(driving.simulator.time + 1.0)
    before = driving.simulator.time
    driving.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.REWIND))
    assert (driving.truth, driving.simulator.time) == (place, before)
    assert world(driving) == ("empty", "")


def test_a_video_shows_a_changed_world_as_a_whole(empty: Client) -> None:
    pytest.importorskip("av")
    films = empty.simulator.simulation.recording
    request = wire.StartRecording(width=64, height=48, rate=10)
    look = films._view_source(request)
    wide = look()
    change(empty, "hall")
    assert empty.simulator.simulation.recording is films
    assert look().position != wide.position
