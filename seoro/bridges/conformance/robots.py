"""Rules about robots: goals, watches, and refusals."""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import (
    Bench,
    Reports,
    distance,
    expect,
    expect_cancelled,
    expect_near,
    expect_refused,
    expect_reported,
    place,
)
from seoro.bridges.wire import Result
from seoro.robotics.geometry import Position3D
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.robots import DrivenRobots, MobileRobots

SUCCEEDED = GoalStatus.SUCCEEDED
NEAR = 0.3  # [m]
LONG = 20.0  # [s]


async def goals_end_once(bench: Bench) -> None:
    """A goal is reached, and its end is reported once."""
    mobile, reports = bench.cast(MobileRobots), Reports()
    await mobile.set_initial_pose(bench.robot, place(0.0, 0.0))
    goal = await mobile.navigate(bench.robot, [place(0.8, 0.0)], stop_at_each=False, report=reports)
    await bench.expect_end("a goal 0.8 m ahead", reports, LONG)
    found = await bench.truth()
    expect(distance(found, (0.8, 0.0)) < NEAR, f"the robot is at {found} instead of (0.8, 0)")
    await bench.pass_time(1.0)
    expect_reported("an ended goal", reports, SUCCEEDED)
    await mobile.cancel_goal(goal)
    expect_reported("a goal cancelled after its end", reports, SUCCEEDED)


async def cancelled_goals_end_and_robots_stop(bench: Bench) -> None:
    """A robot whose goal is cancelled stands still within a second, and accepts another goal."""
    mobile, reports = bench.cast(MobileRobots), Reports()
    await mobile.set_initial_pose(bench.robot, place(0.0, 0.0))
    goal = await mobile.navigate(bench.robot, [place(3.0, 0.0)], stop_at_each=False, report=reports)
    await bench.pass_time(2.0)
    expect(distance(await bench.truth(), (0.0, 0.0)) > 0.1, "a robot with a goal did not move")
    await mobile.cancel_goal(goal)
    await bench.pass_time(1.0)
    before = await bench.truth()
    await bench.expect_still("a robot whose goal was cancelled 1 s ago")
    expect_cancelled("a cancelled goal", reports)
    again = Reports()
    await mobile.navigate(bench.robot, [place(before[0] + 0.5, 0.0)], stop_at_each=False, report=again)
    await bench.expect_end("a goal after a cancelled one", again, LONG)


async def impossible_goals_are_refused(bench: Bench) -> None:
    """Goals of unknown or busy robots, without a known pose or with an invalid target are refused at once."""
    mobile = bench.cast(MobileRobots)

    async def send(robot: str, x: float) -> None:
        await mobile.navigate(robot, [place(x, 0.0)], stop_at_each=False, report=Reports())

    await expect_refused("a goal of a robot without an initial pose", send(bench.robot, 0.5))
    await mobile.set_initial_pose(bench.robot, place(0.0, 0.0))
    await expect_refused("a goal of an unknown robot", send("nobody", 0.5), Result.NOT_FOUND)
    await expect_refused("a goal that is not a number", send(bench.robot, math.nan))
    await expect_refused("a goal 900 m away", send(bench.robot, 900.0))
    await send(bench.robot, 2.0)
    await expect_refused("a second goal of a busy robot", send(bench.robot, 0.5))
    await expect_refused(
        "the initial pose of an unknown robot",
        mobile.set_initial_pose("nobody", place(0.0, 0.0)),
        Result.NOT_FOUND,
    )


async def watches_fire_once(bench: Bench) -> None:
    """A watch fires once, as soon as its condition holds, also if it holds from the start."""
    mobile, near, far, held = bench.cast(MobileRobots), Reports(), Reports(), Reports()
    frame = bench.truth_frame
    watch = await mobile.watch_proximity(bench.robot, frame, "map", Position3D(1.0), 0.4, near)
    await mobile.watch_distance(bench.robot, 0.5, far)
    await mobile.watch_proximity(bench.robot, frame, "map", Position3D(), 0.4, held)
    await bench.grant(0.1)
    expect_reported("a watch whose condition holds from the start", held, SUCCEEDED)
    await bench.cast(DrivenRobots).drive(bench.robot, 0.25, 0.0, 6.0, Reports())
    for what, reports, wanted in (("odometry", far, 0.5), ("place", near, 0.6)):
        await bench.expect_end(f"a watch for {what}", reports, LONG)
        x, _, _ = await bench.truth()
        expect_near(f"the position of the fired watch for {what} [m]", x, wanted, 0.05)
    await bench.pass_time(2.0)
    for reports in (near, far, held):
        expect_reported("a fired watch", reports, SUCCEEDED)
    await mobile.cancel_watch(watch)


async def cancelled_watches_are_silent(bench: Bench) -> None:
    """A cancelled watch is not reported."""
    mobile, reports = bench.cast(MobileRobots), Reports()
    watch = await mobile.watch_distance(bench.robot, 0.2, reports)
    await mobile.cancel_watch(watch)
    await bench.cast(DrivenRobots).drive(bench.robot, 0.25, 0.0, 2.0, Reports())
    await bench.pass_time(2.5)
    expect(not reports.all, f"a cancelled watch was reported as {', '.join(reports.statuses)}")


async def invalid_watches_are_refused(bench: Bench) -> None:
    """Watches of unknown frames and robots, and of invalid distances, are refused."""
    mobile = bench.cast(MobileRobots)
    unknown = mobile.watch_proximity(bench.robot, "nowhere", "map", Position3D(), 0.4, Reports())
    await expect_refused("a watch of an unknown frame", unknown, Result.NOT_FOUND)
    nobody = mobile.watch_distance("nobody", 1.0, Reports())
    await expect_refused("a watch of an unknown robot", nobody, Result.NOT_FOUND)
    for length in (math.nan, -1.0, 0.0):
        watch = mobile.watch_distance(bench.robot, length, Reports())
        await expect_refused(f"a watch for a distance of {length} m", watch)


async def drives_have_their_speed_and_duration(bench: Bench) -> None:
    """A robot that is driven at 0.2 m/s for 2 s has moved 0.4 m within 10 %, has stopped, and reports it once."""
    reports = Reports()
    await bench.cast(DrivenRobots).drive(bench.robot, 0.2, 0.0, 2.0, reports)
    await bench.expect_end("a drive", reports, LONG)
    expect_near("the end of a drive [s]", bench.time, 2.0, 0.1)
    await bench.pass_time(1.0)
    expect_near("the distance of a drive [m]", (await bench.truth())[0], 0.4, 0.04)
    await bench.expect_still("a robot whose drive ended 1 s ago")
    expect_reported("an ended drive", reports, SUCCEEDED)


async def robots_stand_still_after_a_run(bench: Bench) -> None:
    """Robots stop when the run ends, even in motion, and the run may be ended twice."""
    await bench.cast(DrivenRobots).drive(bench.robot, 0.25, 0.3, 30.0, Reports())
    await bench.pass_time(1.0)
    for _ in range(2):
        await bench.backend.end_run()
    await bench.pass_time(1.0)
    await bench.expect_still("a robot whose run ended 1 s ago")
