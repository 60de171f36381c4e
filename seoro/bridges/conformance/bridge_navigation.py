"""Rules of bridges to robots that navigate: goals near by, their feedback, and cancellation.

Goals are the start of the check and a pose `AHEAD` of it, in turn, so the robot stays within 50 cm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import astuple
from typing import Any

import anyio

from seoro.bridges import wire
from seoro.bridges.conformance.bench import (
    Reports,
    distance,
    expect,
    expect_cancelled,
    expect_refused,
    expect_reported,
)
from seoro.bridges.conformance.bridges import AwaitedReports, BridgeRule, HeldRobot
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import GoalStatus, Reporter

AHEAD = 0.4  # [m] from the start to the other goal
TOLERANCE = 0.3  # [m] from a goal that was reached; Nav2 has 0.25 m
CLOSER = 0.1  # [m] that a robot has come closer to its goal, at least
LIMIT = 60.0  # [s] until a goal has ended
MOVING = 0.5  # [s] from the start of a goal to its cancellation
STOPPING = 1.0  # [s] from a cancellation until the robot stands
STILL = 0.05  # [m] noise of a standing robot's pose
SLACK = 0.1  # [m] by which the remaining distance may grow, when the path changes
FEEDBACK_PERIOD = 0.1  # [s]


class Feedback:
    """Keeps the feedback of navigation while a rule runs."""

    def __init__(self) -> None:
        self.all: list[Mapping[str, Any]] = []

    def __call__(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Keep an event if it is feedback."""
        if name == "navigation_feedback":
            self.all.append(arguments)


async def _pose(held: HeldRobot) -> Pose3D:
    """Return the estimated pose of the robot."""
    pose = (await held.node.ask(wire.GET_LOCALIZATION, wire.RobotName(robot=held.robot))).pose
    if pose is None:
        raise AssertionError(f"the localisation of {held.robot} has no pose")
    numbers = (*astuple(pose.position), *astuple(pose.orientation))
    expect(all(map(math.isfinite, numbers)), f"the pose of {held.robot} is not finite: {numbers}")
    return pose


def _apart(first: Pose3D, second: Pose3D) -> float:
    """Return the distance of two poses in the plane [m]."""
    return distance(astuple(first.position), astuple(second.position))


async def _next_goal(held: HeldRobot) -> tuple[Pose3D, float]:
    """Return the farther one of two goals, the start of the check or the pose ahead, and its distance [m]."""
    here = await _pose(held)
    start = held.start = held.start or here
    yaw = start.orientation.yaw
    place = start.position
    ahead = Position3D(place.x + AHEAD * math.cos(yaw), place.y + AHEAD * math.sin(yaw), place.z)
    goal = max((start, Pose3D(ahead, start.orientation)), key=lambda pose: _apart(here, pose))
    return goal, _apart(here, goal)


async def _go(held: HeldRobot, report: Reporter, *poses: Pose3D) -> str:
    """Send the robot through poses; return the id of the goal."""
    request = wire.NavigateThroughPoses(
        id=held.node.new_id("goal"), robot=held.robot, poses=poses, feedback_period=FEEDBACK_PERIOD
    )
    return await held.node.start(wire.NAVIGATE_THROUGH_POSES, request, report)


async def _arrive(held: HeldRobot, what: str) -> None:
    """Send the robot to the next goal, and expect it to arrive."""
    reports = AwaitedReports()
    goal, before = await _next_goal(held)
    await _go(held, reports, goal)
    await reports.wait(LIMIT)
    expect_reported(what, reports, GoalStatus.SUCCEEDED)
    after = _apart(await _pose(held), goal)
    expect(after <= TOLERANCE, f"{what} succeeded {after:.2f} m from it; expected {TOLERANCE:g} m at most")
    expect(after <= before - CLOSER, f"{what} succeeded {after:.2f} m from it; it began {before:.2f} m from it")


async def navigating_robots_have_a_pose(held: HeldRobot) -> None:
    """A robot that navigates has an estimated pose.

    Set the initial pose first, with `init_nav2` or in RViz, and let the bridge serve `get_localization`.
    """
    await _pose(held)


async def impossible_goals_are_refused(held: HeldRobot) -> None:
    """Goals without poses, or with numbers that are not finite, are refused, and the robot stays.

    Check the poses before they are sent to the robot, and refuse the request with a reason.
    """
    here = await _pose(held)
    await expect_refused("a goal without poses", _go(held, Reports()))
    for x in (math.nan, math.inf):
        await expect_refused(f"a goal at x = {x} m", _go(held, Reports(), Pose3D(Position3D(x, here.position.y))))
    moved = _apart(here, await _pose(held))
    expect(moved < STILL, f"a robot whose goals were refused moved by {moved:.2f} m")


async def goals_near_by_are_reached(held: HeldRobot) -> None:
    """A goal near by is reached within the tolerance, and reported once.

    Report success when the robot has arrived. If the robot does not arrive, check its map, costs and tolerance.
    """
    await _arrive(held, f"a goal {AHEAD:g} m away")


async def feedback_approaches_the_goal(held: HeldRobot) -> None:
    """Feedback arrives while a robot navigates, and its remaining distance decreases.

    Send `feedback` events with the progress of the goal, at most once in its `feedback_period`.
    """
    feedback = Feedback()
    await held.node.start_run(feedback, lambda lost: None)
    await _arrive(held, "a goal with feedback")
    await held.node.replay_events()
    expect(bool(feedback.all), "no feedback arrived until the end of the goal")
    lowest, last = math.inf, 0.0
    for each in feedback.all:
        left, since = float(each["distance_remaining"]), float(each["navigation_time"])
        expect(math.isfinite(left) and left >= 0.0, f"the remaining distance is {left} m")
        expect(since >= last, f"the time of navigation goes back from {last:g} s to {since:g} s")
        last = since
        if left == 0.0 and lowest == math.inf:
            continue  # Nav2 sends zero until the first path is known
        expect(left <= lowest + SLACK, f"the remaining distance grows from {lowest:.2f} m to {left:.2f} m")
        lowest = min(lowest, left)


async def navigating_robots_are_busy(held: HeldRobot) -> None:
    """A second goal of a navigating robot is refused, and the first one is reached.

    Keep one goal for each robot, and refuse others until its end.
    """
    reports = AwaitedReports()
    goal, _ = await _next_goal(held)
    await _go(held, reports, goal)
    await expect_refused("a second goal of a navigating robot", _go(held, Reports(), goal))
    await reports.wait(LIMIT)
    expect_reported("a goal during which another was refused", reports, GoalStatus.SUCCEEDED)


async def cancelled_goals_end(held: HeldRobot) -> None:
    """A robot whose goal is cancelled stands within a second, and accepts another goal.

    Cancel the goal on the robot, command zero velocity, and reply when the goal has ended.
    """
    reports = AwaitedReports()
    goal, _ = await _next_goal(held)
    identifier = await _go(held, reports, goal)
    await anyio.sleep(MOVING)
    expect(not reports.all, f"a goal {AHEAD:g} m away has ended after {MOVING:g} s: {', '.join(reports.statuses)}")
    await held.node.cancel_goal(identifier)
    await anyio.sleep(STOPPING)
    first = await _pose(held)
    await anyio.sleep(MOVING)
    moved = _apart(first, await _pose(held))
    expect(moved < STILL, f"a robot whose goal was cancelled {STOPPING:g} s ago moved by {moved:.2f} m")
    expect_cancelled("a cancelled goal", reports)
    second = AwaitedReports()
    await _go(held, second, goal)
    await second.wait(LIMIT)
    expect_reported("a goal after a cancelled one", second, GoalStatus.SUCCEEDED)


NAVIGATING: tuple[BridgeRule, ...] = (
    navigating_robots_have_a_pose,
    impossible_goals_are_refused,
    goals_near_by_are_reached,
    feedback_approaches_the_goal,
    navigating_robots_are_busy,
    cancelled_goals_end,
)
