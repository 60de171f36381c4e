"""Rules about robots: goals, watches, and what is refused."""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import (
    Make,
    Reports,
    distance,
    expect,
    expect_near,
    expect_refused,
    expect_reported,
    place,
    started,
)
from seoro.bridges.wire import Result
from seoro.runtime.capabilities import DrivenRobots, MobileRobots
from seoro.runtime.contracts import GoalStatus, Position3D

SUCCEEDED = GoalStatus.SUCCEEDED
NEAR = 0.3  # [m]
LONG = 20.0  # [s]


async def goals_end_once(make: Make) -> None:
    """A robot that is sent somewhere arrives, and that is reported once."""
    async with started(make) as bench:
        mobile, reports = bench.can(MobileRobots), Reports()
        await mobile.set_initial_pose(bench.robot, place(0.0, 0.0))
        goal = await mobile.navigate(bench.robot, [place(0.8, 0.0)], stop_at_each=False, report=reports)
        await bench.pass_until(LONG, reports.any)
        expect_reported("a goal 0.8 m ahead", reports, SUCCEEDED)
        found = await bench.truth()
        expect(distance(found, (0.8, 0.0)) < NEAR, f"the robot is at {found} instead of (0.8, 0)")
        await bench.pass_time(1.0)
        expect_reported("a goal that has ended", reports, SUCCEEDED)
        await mobile.cancel_goal(goal)
        expect_reported("a goal that was cancelled after its end", reports, SUCCEEDED)


async def cancelled_goals_end_and_robots_stop(make: Make) -> None:
    """A robot whose goal is cancelled stands still within a second, and can be sent elsewhere."""
    async with started(make) as bench:
        mobile, reports = bench.can(MobileRobots), Reports()
        await mobile.set_initial_pose(bench.robot, place(0.0, 0.0))
        goal = await mobile.navigate(bench.robot, [place(3.0, 0.0)], stop_at_each=False, report=reports)
        await bench.pass_time(2.0)
        expect(distance(await bench.truth(), (0.0, 0.0)) > 0.1, "the robot that was sent to a goal did not move")
        await mobile.cancel_goal(goal)
        await bench.pass_time(1.0)
        before = await bench.truth()
        await bench.pass_time(1.0)
        moved = distance(before, await bench.truth())
        expect(moved < 0.01, f"a robot whose goal was cancelled 1 s ago moved {moved:.3f} m in the next")
        expect(
            reports.statuses in ([], ["canceled"]),
            f"a cancelled goal was reported as {', '.join(reports.statuses)}",
        )
        again = Reports()
        await mobile.navigate(bench.robot, [place(before[0] + 0.5, 0.0)], stop_at_each=False, report=again)
        await bench.pass_until(bench.time + LONG, again.any)
        expect_reported("a goal after one that was cancelled", again, SUCCEEDED)


async def impossible_goals_are_refused(make: Make) -> None:
    """Goals that cannot be worked on are refused at once: of nobody, to no place, while busy."""
    async with started(make) as bench:
        mobile = bench.can(MobileRobots)

        async def send(robot: str, x: float) -> None:
            await mobile.navigate(robot, [place(x, 0.0)], stop_at_each=False, report=Reports())

        await expect_refused("a goal of a robot without an initial pose", send(bench.robot, 0.5))
        await mobile.set_initial_pose(bench.robot, place(0.0, 0.0))
        await expect_refused("a goal of an unknown robot", send("nobody", 0.5), Result.NOT_FOUND)
        await expect_refused("a goal that is no number", send(bench.robot, math.nan))
        await expect_refused("a goal 900 m away", send(bench.robot, 900.0))
        await send(bench.robot, 2.0)
        await expect_refused("a second goal of a busy robot", send(bench.robot, 0.5))
        await expect_refused(
            "the initial pose of an unknown robot",
            mobile.set_initial_pose("nobody", place(0.0, 0.0)),
            Result.NOT_FOUND,
        )


async def watches_fire_once(make: Make) -> None:
    """What is watched for is reported once, at the place where it happens; what holds already, at once."""
    async with started(make) as bench:
        mobile, near, far, held = bench.can(MobileRobots), Reports(), Reports(), Reports()
        frame = bench.truth_frame
        watch = await mobile.watch_proximity(bench.robot, frame, "map", Position3D(1.0), 0.4, near)
        await mobile.watch_distance(bench.robot, 0.5, far)
        await mobile.watch_proximity(bench.robot, frame, "map", Position3D(), 0.4, held)
        await bench.grant(0.1)
        expect_reported("a watch for what holds already", held, SUCCEEDED)
        await bench.can(DrivenRobots).drive(bench.robot, 0.25, 0.0, 6.0, Reports())
        for what, reports, wanted in (("odometry", far, 0.5), ("place", near, 0.6)):
            await bench.pass_until(LONG, reports.any)
            expect_reported(f"a watch for {what}", reports, SUCCEEDED)
            x, _, _ = await bench.truth()
            expect_near(f"where the watch for {what} fired [m]", x, wanted, 0.05)
        await bench.pass_time(2.0)
        for reports in (near, far, held):
            expect_reported("a watch that has fired", reports, SUCCEEDED)
        await mobile.cancel_watch(watch)


async def cancelled_watches_are_silent(make: Make) -> None:
    """A watch that is cancelled is not reported any more."""
    async with started(make) as bench:
        mobile, reports = bench.can(MobileRobots), Reports()
        watch = await mobile.watch_distance(bench.robot, 0.2, reports)
        await mobile.cancel_watch(watch)
        await bench.can(DrivenRobots).drive(bench.robot, 0.25, 0.0, 2.0, Reports())
        await bench.pass_time(2.5)
        expect(not reports.all, f"a watch that was cancelled was reported as {', '.join(reports.statuses)}")


async def watches_of_nothing_are_refused(make: Make) -> None:
    """Watches for unknown frames and robots, and for distances that are none, are refused."""
    async with started(make) as bench:
        mobile = bench.can(MobileRobots)
        unknown = mobile.watch_proximity(bench.robot, "nowhere", "map", Position3D(), 0.4, Reports())
        await expect_refused("a watch of an unknown frame", unknown, Result.NOT_FOUND)
        nobody = mobile.watch_distance("nobody", 1.0, Reports())
        await expect_refused("a watch of an unknown robot", nobody, Result.NOT_FOUND)
        for length in (math.nan, -1.0, 0.0):
            watch = mobile.watch_distance(bench.robot, length, Reports())
            await expect_refused(f"a watch for a distance of {length} m", watch)


async def robots_drive_as_long_as_they_are_told(make: Make) -> None:
    """A robot that is driven at 0.2 m/s for 2 s has moved 0.4 m within 10 %, stands, and says so once."""
    async with started(make) as bench:
        reports = Reports()
        await bench.can(DrivenRobots).drive(bench.robot, 0.2, 0.0, 2.0, reports)
        await bench.pass_until(LONG, reports.any)
        expect_reported("a drive", reports, SUCCEEDED)
        expect_near("when it ended [s]", bench.time, 2.0, 0.1)
        await bench.pass_time(1.0)
        before = await bench.truth()
        expect_near("how far it went [m]", before[0], 0.4, 0.04)
        await bench.pass_time(1.0)
        expect(distance(before, await bench.truth()) < 0.01, "a robot moves on 1 s after it was driven")
        expect_reported("a drive that has ended", reports, SUCCEEDED)


async def robots_stand_still_after_a_run(make: Make) -> None:
    """When the run ends robots stop, whatever they were doing, and the end may be said twice."""
    async with started(make) as bench:
        await bench.can(DrivenRobots).drive(bench.robot, 0.25, 0.3, 30.0, Reports())
        await bench.pass_time(1.0)
        for _ in range(2):
            await bench.backend.end_run()
        await bench.pass_time(1.0)
        before = await bench.truth()
        await bench.pass_time(1.0)
        moved = distance(before, await bench.truth())
        expect(moved < 0.01, f"1 s after the run has ended, its robot moves {moved:.3f} m in a second")
