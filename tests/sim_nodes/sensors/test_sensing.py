"""Samples of sensors of a robot in a world, and watches on them."""

from __future__ import annotations

import math

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from tests.sim_nodes.client import ROBOT, Client, pose


def sample(client: Client, sensor: str) -> wire.SensorSample:
    return client.ask(wire.GET_SENSOR_SAMPLE, wire.SensorName(robot=ROBOT, sensor=sensor))


def drive(client: Client, linear: float) -> None:
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=linear, angular=0.0, duration=60.0))


def break_sensor(client: Client, device: str, fault: wire.Fault) -> None:
    request = wire.InjectFault(id=f"{device} fault", robot=ROBOT, device=device, fault=fault, limit=100.0)
    client.ask(wire.INJECT_FAULT, request)


def watch_bumper(client: Client, zone: str = "", entity: str = "") -> None:
    client.ask(wire.WATCH_BUMPER, wire.WatchBumper(id="bump", robot=ROBOT, zone=zone, entity=entity))


def check_rate(client: Client, sensor: str, lowest: float, highest: float, duration: float = 1.0) -> None:
    request = wire.CheckRate(
        id="rate", robot=ROBOT, sensor=sensor, lowest=lowest, highest=highest, duration=duration
    )
    client.ask(wire.CHECK_RATE, request)


@pytest.mark.parametrize("sensor", ["lidar", "odometry", "imu", "bumper"])
def test_the_latest_sample_is_returned_after_the_first_arrival(sensor: str, maze: Client) -> None:
    with pytest.raises(RequestRefused, match=f"no sample of turtlebot4/{sensor} has arrived yet"):
        sample(maze, sensor)
    maze.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=60))  # 0.24 s
    found = sample(maze, sensor)
    assert found.time == pytest.approx(0.2 if sensor == "lidar" else 0.24)
    parts = found.model_dump(exclude={"time"})
    assert [name for name, part in parts.items() if part is not None] == [sensor]


def test_samples_contain_the_expected_values(maze: Client) -> None:
    for sensor in ("lidar", "imu", "bumper"):
        maze.simulator.simulation.pipeline(ROBOT, sensor).in_use = True
    maze.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=250))
    scan, odometry = sample(maze, "lidar").lidar, sample(maze, "odometry").odometry
    imu, bumper = sample(maze, "imu").imu, sample(maze, "bumper").bumper
    assert scan is not None
    assert len(scan.ranges) == len(scan.bearings) == 360
    assert odometry is not None
    assert abs(odometry.travelled) < 0.01
    assert imu is not None
    assert imu.acceleration.z == pytest.approx(9.81, abs=0.3)
    assert bumper == wire.BumperSample(bumps=())


@pytest.mark.parametrize("engine", ENGINES)
def test_a_bump_is_reported_by_zone_and_entity(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.spawn("box", pose(0.6, 0.0, z=0.1))
    drive(client, 0.3)
    watch_bumper(client, "bump_front_center", "box")
    bumped, contacts = client.run_until("bump")
    assert [contact.time for contact in contacts] == [pytest.approx(bumped.time, abs=0.03)]
    bumper = sample(client, "bumper").bumper
    assert bumper is not None
    [bump] = bumper.bumps
    assert (bump.zone, bump.entity) == ("bump_front_center", "box")
    assert bump.since == pytest.approx(bumped.time, abs=0.03)


def test_a_bump_of_another_zone_is_reported_separately(empty: Client) -> None:
    empty.spawn("box", pose(-0.6, 0.0, z=0.1))
    drive(empty, -0.3)
    watch_bumper(empty)
    while empty.simulator.simulation.time < 3.0:
        assert empty.advance(3.0).occurrences == ()  # it has no zones behind


def test_a_bumper_without_power_reports_nothing(empty: Client) -> None:
    empty.spawn("box", pose(0.6, 0.0, z=0.1))
    drive(empty, 0.3)
    break_sensor(empty, "bumper", wire.PowerLoss())
    watch_bumper(empty)
    occurred: list[str] = []
    time = 0.0
    while time < 4.0:
        advanced = empty.advance(4.0)
        time, occurred = advanced.time, [*occurred, *(each.id for each in advanced.occurrences)]
    assert occurred == ["bumper fault"]


def test_the_next_sample_is_reported_when_it_arrives(maze: Client) -> None:
    maze.ask(wire.WATCH_SENSOR, wire.WatchSensor(id="scan", robot=ROBOT, sensor="lidar"))
    assert maze.run_until("scan")[0].time == pytest.approx(0.1)
    break_sensor(maze, "lidar", wire.Delay(time=0.06))
    maze.ask(wire.WATCH_SENSOR, wire.WatchSensor(id="next", robot=ROBOT, sensor="lidar"))
    assert maze.run_until("next")[0].time == pytest.approx(0.26)


def test_a_near_obstacle_is_reported_by_bearing(empty: Client) -> None:
    empty.spawn("box", pose(0.0, 1.0, z=0.1))
    ahead = wire.WatchRange(id="ahead", robot=ROBOT, sensor="lidar", distance=1.0, start=-0.5, end=0.5)
    left = wire.WatchRange(id="left", robot=ROBOT, sensor="lidar", distance=1.0, start=1.0, end=2.0)
    empty.ask(wire.WATCH_RANGE, ahead)
    empty.ask(wire.WATCH_RANGE, left)
    [occurrence] = empty.advance(1.0).occurrences
    assert occurrence.id == "left"
    assert empty.advance(1.0).occurrences == ()


def test_rate_watches_detect_lost_samples(maze: Client) -> None:
    check_rate(maze, "lidar", 9.5, 10.5)
    ended, _ = maze.run_until("rate")
    assert ended.outcome is Outcome.SUCCEEDED
    assert ended.message == (
        "10 samples of turtlebot4/lidar have arrived in 1 s, 10 a second; expected 9.5 to 10.5"
    )
    break_sensor(maze, "lidar", wire.MessageLoss(probability=0.5))
    check_rate(maze, "lidar", 9.5, 10.5, 2.0)
    ended, _ = maze.run_until("rate")
    assert ended.outcome is Outcome.ABORTED


def test_watches_continue_after_a_reset(maze: Client) -> None:
    maze.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=100))
    check_rate(maze, "imu", 49.0, 51.0)
    maze.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=50))
    maze.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE))
    assert maze.run_until("rate")[0].outcome is Outcome.SUCCEEDED


def test_invalid_requests_are_refused(maze: Client) -> None:
    with pytest.raises(
        RequestRefused, match="unknown sensor 'nose' of turtlebot4; sensors: bumper, imu, lidar, odometry"
    ):
        sample(maze, "nose")
    with pytest.raises(RequestRefused, match=r"unknown zone 'back' .*; zones: bump_right, bump_front_right"):
        watch_bumper(maze, "back")
    for start, end, distance, message in ((math.nan, 0.0, 1.0, "bearings"), (0.0, 1.0, -1.0, "distance")):
        with pytest.raises(RequestRefused, match=message):
            request = wire.WatchRange(
                id="near", robot=ROBOT, sensor="lidar", distance=distance, start=start, end=end
            )
            maze.ask(wire.WATCH_RANGE, request)
    with pytest.raises(RequestRefused, match="turtlebot4/imu does not measure ranges"):
        request = wire.WatchRange(id="near", robot=ROBOT, sensor="imu", distance=1.0, start=0.0, end=1.0)
        maze.ask(wire.WATCH_RANGE, request)
    with pytest.raises(RequestRefused, match="expected bounds of zero or more, the lower one first"):
        check_rate(maze, "lidar", 11.0, 9.0)
    with pytest.raises(RequestRefused, match=r"nan s for counting samples; expected 0\.02 to 3600 s"):
        check_rate(maze, "lidar", 9.0, 11.0, math.nan)
