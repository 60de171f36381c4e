from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import ResetScope, SensorName, SimulationState
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.node import keep_pace
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import needs_pictures

pytestmark = pytest.mark.engine("mujoco")

LIDAR, ODOMETRY, IMU = (SensorName(robot=ROBOT, sensor=name) for name in ("lidar", "odometry", "imu"))


@dataclass
class Tray:
    """Keeps published messages."""

    reported: list[wire.StreamUpdate] = field(default_factory=list)
    has_subscribers: bool = True
    is_closed: bool = False

    def put(self, payload: bytes) -> None:
        self.reported.append(wire.decode(wire.StreamUpdate, payload, wire.ANSWER))

    def close(self) -> None:
        self.is_closed = True

    @property
    def samples(self) -> list[wire.StreamedSample]:
        return [sample for reported in self.reported for sample in reported.samples]

    def of(self, sensor: str) -> list[wire.SensorSample]:
        return [each.sample for each in self.samples if each.sensor == sensor]


def streaming(client: Client, name: str = "view", **wanted: object) -> Tray:
    """Open a stream; return its tray."""
    tray = Tray()
    client.simulator.streams.connect(lambda _: tray)
    client.ask(wire.OPEN_STREAM, wire.OpenStream.model_validate({"id": name, **wanted}))
    return tray


@pytest.mark.parametrize("engine", ENGINES)
def test_samples_are_published_in_the_tick_in_which_they_arrive(engine: str) -> None:
    client = Client("empty", engine=engine)
    tray = streaming(client, sensors=(LIDAR, ODOMETRY))
    client.advance(0.21)
    assert [reported.time for reported in tray.reported] == pytest.approx([0.02 * tick for tick in range(1, 11)])
    assert [reported.number for reported in tray.reported] == list(range(1, 11))
    assert [sample.time for sample in tray.of("lidar")] == pytest.approx([0.1, 0.2])
    assert len(tray.of("odometry")) == 10
    scan = tray.of("lidar")[0].lidar
    assert scan is not None
    assert len(scan.ranges) == 360
    assert not any(reported.poses or reported.joints for reported in tray.reported)


@pytest.mark.parametrize("steps", [False, True])
def test_streams_are_equal_for_grants_and_playing(empty: Client, steps: bool) -> None:
    tray = streaming(empty, sensors=(IMU,), joints=(ROBOT,))
    if steps:
        empty.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=50))
    else:
        empty.ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=SimulationState.PLAYING))
        for clock in range(40):
            keep_pace(empty.simulator, 0.01 * clock)
    times = [sample.time for sample in tray.of("imu")]
    assert times[:10] == pytest.approx([0.02 * tick for tick in range(1, 11)])
    joints = tray.reported[-1].joints[0].joints
    assert joints.names == ("left_wheel_joint", "right_wheel_joint")
    assert joints.positions == pytest.approx((0.0, 0.0), abs=1e-3)


def test_localised_poses_are_published(maze: Client) -> None:
    tray = streaming(maze, poses=(ROBOT,))
    maze.advance(0.2)
    assert not any(reported.poses for reported in tray.reported)
    maze.localise(pose(0.1, 0.0, 0.2))
    maze.advance(0.4)
    [last] = [reported.poses for reported in tray.reported if reported.poses][-1]
    estimate = maze.estimate
    assert (last.base.position.x, last.base.position.y) == pytest.approx((estimate.x, estimate.y))
    assert 0.0 < last.deviation < 0.3


def test_joints_of_an_arm_are_published(empty: Client) -> None:
    cell = Client("arm_cell")
    tray = streaming(cell, joints=("ur10e",))
    cell.advance(0.1)
    joints = tray.reported[-1].joints[0].joints
    assert joints == cell.ask(wire.GET_JOINT_STATES, wire.RobotName(robot="ur10e"))


def test_streams_do_not_change_the_simulation() -> None:
    ends = []
    for wanted in (False, True):
        client = Client("maze", 5)
        if wanted:
            streaming(client, sensors=(LIDAR, IMU, ODOMETRY), poses=(ROBOT,), joints=(ROBOT,))
        client.localise()
        client.navigate(pose(0.4, 0.0))
        occurrence, _ = client.run_until("goal")
        ends.append((occurrence, client.truth, client.estimate))
    assert ends[0] == ends[1]


def test_streams_outlast_resets_and_worlds(maze: Client) -> None:
    tray = streaming(maze, sensors=(LIDAR,))
    for scope in (ResetScope.STATE, ResetScope.DEFAULT):
        maze.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=scope))
        tray.reported.clear()
        maze.advance(maze.simulator.time + 0.11)
        assert len(tray.of("lidar")) == 1
    maze.ask(wire.LOAD_WORLD, wire.LoadWorld(world="arm_cell"))
    tray.reported.clear()
    maze.advance(0.11)
    assert (len(tray.reported), tray.samples) == (5, [])
    maze.ask(wire.LOAD_WORLD, wire.LoadWorld(world="empty"))
    maze.advance(0.11)
    assert len(tray.of("lidar")) == 1
    maze.ask(wire.CLOSE_STREAM, wire.StreamName(id="view"))
    assert tray.is_closed
    tray.reported.clear()
    maze.advance(0.3)
    assert tray.reported == []


def test_a_stream_closes_after_its_last_subscriber(empty: Client) -> None:
    tray = streaming(empty)
    tray.has_subscribers = False  # the subscription is not known yet
    empty.advance(1.2)
    assert not tray.is_closed
    tray.has_subscribers = True
    empty.advance(2.5)
    tray.has_subscribers = False
    empty.advance(4.1)
    assert tray.is_closed
    assert tray.reported[-1].time <= 4.0


def test_open_streams_prevent_simulating_ahead(empty: Client) -> None:
    tray = streaming(empty)
    assert empty.ask(wire.ADVANCE, wire.Advance(until=0.1, horizon=4.0)).time == pytest.approx(0.1)
    assert tray.reported[-1].time == pytest.approx(0.1)
    assert empty.simulator.time == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ({"sensors": (SensorName(robot="r2", sensor="lidar"),)}, "unknown robot 'r2'"),
        (
            {"sensors": (SensorName(robot=ROBOT, sensor="radar"),)},
            "unknown sensor 'radar' of turtlebot4; sensors: bumper",
        ),
        ({"poses": ("r2",)}, "unknown robot 'r2'"),
        ({"joints": ("r2",)}, "unknown robot 'r2'"),
        ({"id": "view"}, "duplicate stream 'view'"),
    ],
)
def test_invalid_streams_are_refused(empty: Client, wanted: dict[str, object], words: str) -> None:
    streaming(empty)
    with pytest.raises(RequestRefused, match=words):
        empty.ask(wire.OPEN_STREAM, wire.OpenStream.model_validate({"id": "other", **wanted}))


def test_streams_without_a_node_are_refused(empty: Client) -> None:
    with pytest.raises(RequestRefused, match="does not publish streams"):
        empty.ask(wire.OPEN_STREAM, wire.OpenStream(id="view"))
    with pytest.raises(RequestRefused, match="unknown stream 'view'; open streams: none"):
        empty.ask(wire.CLOSE_STREAM, wire.StreamName(id="view"))


def test_the_number_of_streams_is_limited(empty: Client) -> None:
    for number in range(16):
        streaming(empty, f"view{number}")
    with pytest.raises(RequestRefused, match="too many streams: 16"):
        streaming(empty, "one_more")


@pytest.mark.parametrize("engine", ENGINES)
def test_pictures_are_streamed_at_10_hz(engine: str) -> None:
    needs_pictures(engine)
    client = Client("maze", engine=engine)
    camera = f"{ROBOT}/front"
    tray = streaming(client, cameras=(camera,))
    client.advance(0.25)
    pictures = [picture for update in tray.reported for picture in update.pictures]
    assert [picture.time for picture in pictures] == pytest.approx([0.1, 0.2])
    assert (pictures[0].camera, len(pictures[0].pixels)) == (camera, 640 * 480 * 3)
    with pytest.raises(RequestRefused, match="unknown camera 'turtlebot4/back'"):
        streaming(client, "other", cameras=(f"{ROBOT}/back",))


def test_sensors_are_computed_only_while_a_stream_is_open(empty: Client) -> None:
    streaming(empty, sensors=(LIDAR,))
    lidar = empty.simulator.simulation.pipeline(ROBOT, "lidar")
    empty.advance(0.25)
    assert (lidar.count, lidar.in_use) == (2, False)
    empty.ask(wire.CLOSE_STREAM, wire.StreamName(id="view"))
    empty.advance(0.55)
    assert lidar.count == 2
