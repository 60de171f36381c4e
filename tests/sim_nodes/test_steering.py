"""Robots that are driven by velocities."""

from __future__ import annotations

import math

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from tests.sim_nodes.client import ROBOT, Client, pose


def drive(
    client: Client,
    linear: float,
    angular: float = 0.0,
    duration: float = 3.0,
    robot: str = ROBOT,
    goal: str = "drive",
) -> None:
    request = wire.Drive(id=goal, robot=robot, linear=linear, angular=angular, duration=duration)
    client.ask(wire.DRIVE, request)


def command(client: Client, linear: float, robot: str = ROBOT, **rest: float) -> None:
    twist = wire.Twist(linear=wire.Vector3(x=linear, **rest))
    client.ask(wire.CMD_VEL, wire.CmdVel(robot=robot, twist=twist))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_drives_for_the_duration_and_stops(engine: str) -> None:
    client = Client("empty", engine=engine)
    drive(client, 0.3)
    advanced = client.advance(10.0)
    [ended] = advanced.occurrences
    assert (ended.id, ended.outcome, ended.time, advanced.time) == ("drive", Outcome.SUCCEEDED, 3.0, 3.0)
    client.advance(4.0)
    there = client.truth
    # It takes a third of a second to reach its speed, at 0.9 m/s^2, and 2 cm to stop.
    assert there.x == pytest.approx(0.9 - 0.3**2 / 2 / 0.9 + 0.01, abs=0.03)
    client.advance(5.0)
    assert client.truth.distance(there.x, there.y) < 1e-3


def test_turning_is_to_the_left(empty: Client) -> None:
    drive(empty, 0.0, 0.5, 2.0)
    empty.run_until("drive")
    assert empty.truth.yaw == pytest.approx(1.0, abs=0.1)


def test_a_robot_stops_when_its_drive_is_cancelled(empty: Client) -> None:
    drive(empty, 0.3, duration=100.0)
    empty.advance(2.0)
    empty.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="drive"))
    [ended] = empty.advance(3.0).occurrences
    assert (ended.id, ended.outcome, ended.time) == ("drive", Outcome.CANCELED, 2.0)
    empty.advance(2.5)
    there = empty.truth
    empty.advance(5.0)
    assert empty.truth.distance(there.x, there.y) < 1e-3


def test_a_velocity_command_expires_after_half_a_second(empty: Client) -> None:
    for second in range(1, 5):
        command(empty, 0.3)
        empty.advance(second * 0.4)
    moving = empty.truth.x
    assert moving > 0.3
    empty.advance(3.0)
    stopped = empty.truth.x
    assert moving < stopped < moving + 0.08
    assert empty.advance(5.0).occurrences == ()
    assert empty.truth.x == pytest.approx(stopped, abs=1e-3)


def test_a_command_without_a_robot_goes_to_the_first_wheeled_one(empty: Client) -> None:
    command(empty, 0.3, robot="")
    empty.advance(1.0)
    assert empty.truth.x > 0.05


def test_a_busy_robot_refuses_velocities(empty: Client) -> None:
    empty.localise()
    drive(empty, 0.1)
    with pytest.raises(RequestRefused, match="is busy with goal 'drive'") as refused:
        empty.navigate(pose(1.0, 0.0))
    assert refused.value.code == Result.INCORRECT_STATE
    with pytest.raises(RequestRefused, match="is busy with goal 'drive'"):
        command(empty, 0.1)
    with pytest.raises(RequestRefused, match="duplicate id 'drive'"):
        drive(empty, 0.1)
    empty.run_until("drive")
    command(empty, -0.2)
    empty.navigate(pose(1.0, 0.0))  # the next command or goal replaces a command
    assert empty.run_until("goal")[0].outcome is Outcome.SUCCEEDED


@pytest.mark.parametrize(
    ("linear", "angular", "duration", "words"),
    [
        (0.4, 0.0, 1.0, "expected up to 0.306 m/s"),
        (0.1, -2.0, 1.0, "and 1.9 rad/s"),
        (math.nan, 0.0, 1.0, "finite number"),
        (0.1, math.inf, 1.0, "finite number"),
        (0.1, 0.0, math.nan, "invalid duration nan s"),
        (0.1, 0.0, 0.0, "invalid duration 0.0 s"),
        (0.1, 0.0, 1e9, "at most 86400 s"),
    ],
)
def test_invalid_velocities_are_refused(
    empty: Client, linear: float, angular: float, duration: float, words: str
) -> None:
    with pytest.raises(RequestRefused, match=words):
        drive(empty, linear, angular, duration)
    assert empty.advance(0.5).occurrences == ()
    assert empty.truth.x == pytest.approx(0.0, abs=1e-3)


def test_velocities_beyond_the_limits_are_refused(empty: Client) -> None:
    with pytest.raises(RequestRefused, match=r"unsupported motion of turtlebot4 sideways: .* differential"):
        command(empty, 0.1, y=0.1)
    with pytest.raises(RequestRefused, match="only linear x and y, and angular z"):
        command(empty, 0.1, z=0.1)
    with pytest.raises(RequestRefused, match="finite number"):
        command(empty, math.nan)
    with pytest.raises(RequestRefused, match="unknown robot 'other'; robots: turtlebot4"):
        command(empty, 0.1, robot="other")
