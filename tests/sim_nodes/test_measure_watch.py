from __future__ import annotations

import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from seoro.robotics.geometry import Orientation3D, Pose3D, Position3D
from seoro.robotics.measures import Area, Measure, MeasureLimit
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.manipulation.cell import box

engines = pytest.mark.parametrize("engine", ["mujoco", "pybullet"])


def watch(client: Client, limit: MeasureLimit, entity: str = ROBOT, name: str = "watch") -> None:
    client.ask(wire.WATCH_MEASURE, wire.WatchMeasure(id=name, entity=entity, limit=limit))


def drive(client: Client, linear: float = 0.3) -> None:
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=linear, angular=0.0, duration=5.0))


@engines
def test_a_clearance_is_reported_in_the_tick_in_which_it_falls_to_the_limit(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.spawn("box", pose(1.2, 0.0, z=0.1))
    client.spawn("far", pose(-1.5, 0.0, z=0.1))
    watch(client, MeasureLimit(Measure.CLEARANCE, 0.3, above=False))
    watch(client, MeasureLimit(Measure.CLEARANCE, 0.3, above=False, other="far"), name="never")
    drive(client)
    found, _ = client.run_until("watch", 5.0)
    clearance = client.simulator.simulation.clearance(ROBOT, "")
    assert clearance is not None and clearance.entity == "box"
    assert 0.3 - 0.3 * 0.02 <= clearance.distance <= 0.3
    assert f"turtlebot4 has a clearance of {clearance.distance:.3f} m to 'box' at (" in found.message
    assert found.message.endswith(f"{found.time:.3f} s after the start; expected more than 0.3 m")


def test_each_measure_is_watched(empty: Client) -> None:
    empty.localise(pose(0.2, 0.0))  # 0.2 m ahead of the truth
    drive(empty)
    limits = {
        "fast": MeasureLimit(Measure.SPEED, 0.2, above=True),
        "fast_there": MeasureLimit(Measure.SPEED, 0.2, above=True, area=Area(x_min=0.4)),
        "lost": MeasureLimit(Measure.LOCALIZATION_ERROR, 0.1, above=True),
        "way": MeasureLimit(Measure.PATH_LENGTH, 0.5, above=True),
        "out": MeasureLimit(Measure.AREA_DISTANCE, 0.0, above=True, area=Area(x_max=0.6)),
        "in": MeasureLimit(Measure.AREA_DISTANCE, 0.0, above=False, area=Area(x_min=0.7)),
        "stay": MeasureLimit(Measure.TIME_IN_AREA, 0.5, above=True, area=Area(x_min=0.7)),
    }
    for name, limit in limits.items():
        watch(empty, limit, name=name)
    fired: dict[str, tuple[float, float]] = {}
    while len(fired) < len(limits):
        for each in empty.advance(5.0).occurrences:
            fired[each.id] = (each.time, empty.truth.x)
        assert empty.simulator.simulation.time < 5.0
    assert fired["lost"][0] <= 0.02
    assert fired["fast"][1] < 0.3
    assert fired["fast_there"][1] == pytest.approx(0.4, abs=0.01)
    assert fired["way"][1] == pytest.approx(0.5, abs=0.01)
    assert fired["out"][1] == pytest.approx(0.6, abs=0.01)
    assert fired["in"][1] == pytest.approx(0.7, abs=0.01)
    assert fired["stay"][0] == pytest.approx(fired["in"][0] + 0.52, abs=0.03)


def test_watches_return_their_margin(empty: Client) -> None:
    empty.spawn("box", pose(1.2, 0.0, z=0.1))
    limits = {
        "near": MeasureLimit(Measure.CLEARANCE, 0.5, above=False, other="box"),
        "hit": MeasureLimit(Measure.CLEARANCE, 0.7, above=False),
        "fast": MeasureLimit(Measure.SPEED, 1.0, above=True),
        "way": MeasureLimit(Measure.PATH_LENGTH, 1.0, above=True),
        "in": MeasureLimit(Measure.AREA_DISTANCE, 0.0, above=True, area=Area(x_max=0.6)),
        "out": MeasureLimit(Measure.AREA_DISTANCE, 0.0, above=False, area=Area(x_min=0.7)),
    }
    for name, limit in limits.items():
        watch(empty, limit, name=name)
    drive(empty)
    found, _ = empty.run_until("hit", 5.0)
    clearance = empty.simulator.simulation.clearance(ROBOT, "")
    assert clearance is not None and found.margin == clearance.distance - 0.7 <= 0.0
    margins = {
        name: empty.ask(wire.CANCEL_WATCH, wire.CancelWatch(id=name)).margin for name in limits if name != "hit"
    }
    assert margins["near"] == clearance.distance - 0.5
    x = empty.truth.x
    assert margins["way"] == pytest.approx(1.0 - x, abs=1e-3)
    assert margins["fast"] == pytest.approx(0.7, abs=0.02)
    assert margins["in"] == pytest.approx(0.6 - x, abs=1e-9) and margins["out"] == pytest.approx(0.7 - x, abs=1e-9)
    far = wire.Position3D(x=9.0)
    other = wire.WatchProximity(id="other", frame="base_link", parent_frame="odom", point=far, threshold=0.1)
    empty.ask(wire.WATCH_PROXIMITY, other)
    assert empty.ask(wire.CANCEL_WATCH, wire.CancelWatch(id="other")).margin is None


@engines
def test_a_body_that_falls_over_reaches_a_tilt(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.spawn("pole", Pose3D(Position3D(1.2, 0.0, 0.52), Orientation3D(pitch=0.2)), box(0.1, 0.1, 1.0))
    watch(client, MeasureLimit(Measure.TILT, 0.5, above=True), "pole")
    watch(client, MeasureLimit(Measure.TILT, 0.1, above=True), name="robot")
    found, _ = client.run_until("watch", 3.0)
    assert 0.1 < found.time < 2.0
    assert "pole has a tilt of 0.5" in found.message and found.message.endswith("expected at most 0.5 rad")


def test_watches_of_measures_continue_after_a_snapshot(empty: Client) -> None:
    drive(empty)
    watch(empty, MeasureLimit(Measure.PATH_LENGTH, 0.4, above=True))
    empty.advance(1.0)
    snapshot = empty.ask(wire.SAVE_STATE, wire.Empty())
    fired = empty.run_until("watch", 5.0)
    fork = Client("maze", 99)
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.CONTINUE))
    assert fork.run_until("watch", 5.0) == fired


def test_a_deleted_entity_reaches_no_limit(empty: Client) -> None:
    empty.spawn("box", pose(1.2, 0.0, z=0.1))
    watch(empty, MeasureLimit(Measure.SPEED, 0.0, above=False), "box", "box")
    assert empty.run_until("box", 2.0)
    watch(empty, MeasureLimit(Measure.PATH_LENGTH, 0.1, above=True), "box")
    watch(empty, MeasureLimit(Measure.CLEARANCE, 0.2, above=False, other="box"), name="near")
    empty.ask(wire.DELETE_ENTITY, wire.EntityName(name="box"))
    drive(empty)
    assert empty.advance(4.0).occurrences == ()


@pytest.mark.parametrize(
    ("entity", "limit", "error"),
    [
        ("tb5", MeasureLimit(Measure.SPEED, 1.0, above=True), "unknown entity 'tb5'"),
        ("box", MeasureLimit(Measure.CLEARANCE, 1.0, above=False), "unknown robot 'box'"),
        (ROBOT, MeasureLimit(Measure.CLEARANCE, 1.0, above=False, other="tree"), "unknown entity 'tree' to keep"),
        (ROBOT, MeasureLimit(Measure.CLEARANCE, 1.0, above=False, other=ROBOT), "to itself"),
        (ROBOT, MeasureLimit(Measure.SPEED, float("nan"), above=True), "invalid limit"),
        ("box", MeasureLimit(Measure.WORK, 1.0, above=True), "unknown robot 'box'"),
        (ROBOT, MeasureLimit(Measure.SPEED, 1.0, above=True, area=Area(x_min=2.0, x_max=1.0)), "invalid area"),
    ],
)
def test_invalid_watches_are_refused(empty: Client, entity: str, limit: MeasureLimit, error: str) -> None:
    empty.spawn("box", pose(1.2, 0.0, z=0.1))
    with pytest.raises(RequestRefused, match=error):
        watch(empty, limit, entity)


@engines
def test_the_work_of_motors_is_measured_and_limited(engine: str) -> None:
    client = Client("empty", engine=engine)
    drive(client)
    watch(client, MeasureLimit(Measure.WORK, 0.05, above=True))
    found, _ = client.run_until("watch", 5.0)
    assert 0.0 < found.time < 1.0  # while it speeds up
    assert "turtlebot4 has a work of 0.0" in found.message and "expected at most 0.05 J" in found.message
    snapshot = client.ask(wire.SAVE_STATE, wire.Empty())
    client.run_until("drive", 6.0)
    work = client.ask(wire.GET_MEASUREMENTS, wire.Empty()).robots[ROBOT].work
    assert work is not None and 5.0 < work < 8.0  # damped wheels need 1.4 W at 0.3 m/s
    client.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.CONTINUE))
    client.run_until("drive", 6.0)
    assert client.ask(wire.GET_MEASUREMENTS, wire.Empty()).robots[ROBOT].work == work


@engines
def test_work_does_not_depend_on_the_size_of_grants(engine: str) -> None:
    works = []
    for grant in (0.004, 0.7):
        client = Client("empty", engine=engine)
        drive(client)
        watch(client, MeasureLimit(Measure.WORK, 100.0, above=True))
        for number in range(1, round(1.4 / grant) + 1):
            client.advance(round(number * grant, 3))
        works.append(client.ask(wire.GET_MEASUREMENTS, wire.Empty()).robots[ROBOT].work or 0.0)
    assert works[0] == works[1] > 0.5


def test_arms_do_work() -> None:
    client = Client("arm_cell")
    client.advance(1.0)
    rested = client.ask(wire.GET_MEASUREMENTS, wire.Empty()).robots["ur10e"]
    assert rested.work is not None and rested.work < 0.1 and rested.closest_approach is None
    target = wire.FollowJointTrajectory(id="move", robot="ur10e", points=((0.5, -1.5, 1.5, -1.5, -1.5, 0.0),))
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, target)
    client.run_until("move", 20.0)
    moved = client.ask(wire.GET_MEASUREMENTS, wire.Empty()).robots["ur10e"]
    assert moved.work is not None and moved.work > rested.work + 1.0
    assert moved.path_length == 0.0
