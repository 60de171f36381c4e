"""Rules about robots and time, which passes in grants only: goals, watches, and refusals."""

from __future__ import annotations

import math

import anyio

from seoro.bridges.conformance.bench import (
    BOX,
    STEP,
    Bench,
    Make,
    Reports,
    distance,
    expect,
    expect_cancelled,
    expect_near,
    expect_refused,
    expect_reported,
    place,
    rule,
    started,
)
from seoro.bridges.wire import Result
from seoro.robotics.geometry import Position3D
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.robots import DrivenRobots, MobileRobots
from seoro.runtime.contracts.worlds import Frames, Simulation

PAUSE = 0.1  # [s] of the machine's clock


@rule()
async def time_passes_in_grants(bench: Bench) -> None:
    """Without events, a grant reaches its time, and at most a step beyond."""
    for until in (0.02, 0.5, 0.503, 3.0):
        await bench.grant(until)
        expect_near(f"the reached time of a grant to {until} s [s]", bench.time, until, STEP)


@rule()
async def time_never_goes_back(bench: Bench) -> None:
    """A grant of a past time changes nothing, and returns the present time."""
    await bench.grant(1.0)
    for until in (1.0, 0.5, 0.0, -1.0):
        found = await bench.backend.advance(until)
        expect(found == bench.time, f"at {bench.time} s, a grant to {until} s reached {found} s")


@rule(DrivenRobots, Frames)
async def time_stands_still_without_grants(bench: Bench) -> None:
    """Between grants nothing moves, even while requests are answered."""
    await bench.cast(DrivenRobots).drive(bench.robot, 0.2, 0.0, 10.0, Reports())
    await bench.grant(1.0)
    before = await bench.truth()
    await anyio.sleep(PAUSE)
    after = await bench.truth()
    expect(before == after, f"the robot moved from {before} to {after} without a grant")
    found = await bench.backend.advance(bench.time)
    expect(found == bench.time, f"the time changed from {bench.time} s to {found} s without a grant")


@rule(DrivenRobots, Frames)
async def requests_apply_at_the_time_of_the_run(make: Make) -> None:
    """Requests apply at the time of the last grant, for short and long grants."""
    poses = []
    for small in (False, True):
        async with started(make) as bench:
            driving = bench.cast(DrivenRobots)
            await driving.drive(bench.robot, 0.2, 0.3, 30.0, Reports())
            await bench.grant(0.1)
            for until in (1.0, 1.02, 3.0):
                while small and bench.time + 0.02 < until:
                    await bench.grant(bench.time + 0.02)
                await bench.grant(until)
                poses.append(await bench.truth())
    one, other = poses[:3], poses[3:]
    expect(one == other, f"the robot was at {other} after small grants, and at {one} after large ones")


@rule(MobileRobots, DrivenRobots, Simulation)
async def grants_end_at_events(bench: Bench) -> None:
    """A grant ends early at the first event, and returns after the event's report."""
    await bench.cast(DrivenRobots).drive(bench.robot, 0.2, 0.0, 10.0, Reports())
    reports = Reports()
    await bench.cast(MobileRobots).watch_distance(bench.robot, 0.3, reports)
    await bench.grant(30.0)
    expect(bench.time < 10.0, f"a grant in which a watch fired ended at {bench.time} s")
    number = len(reports.all)
    expect(number == 1, f"at the end of a grant, its fired watch had {number} reports")


@rule(MobileRobots, Simulation)
async def equal_runs_are_reproducible(make: Make) -> None:
    """Two runs with the same world, seed and requests are the same, bit for bit."""
    first, second = [await _run(make) for _ in range(2)]
    for index, (one, other) in enumerate(zip(first, second, strict=False)):
        expect(one == other, f"observation {index} is {other!r} in a second run, and {one!r} in the first")
    expect(len(first) == len(second), f"a second run has {len(second)} observations, the first {len(first)}")


async def _run(make: Make) -> list[object]:
    """Return the observations of a run."""
    seen: list[object] = []
    async with started(make) as bench:
        reports = Reports()
        await bench.cast(MobileRobots).set_initial_pose(bench.robot, place(0.0, 0.0))
        await bench.cast(MobileRobots).navigate(bench.robot, [place(1.0, 0.5)], stop_at_each=False, report=reports)
        for number in range(10):
            await bench.grant(bench.time + 0.31)
            believed = await bench.cast(Simulation).relative_pose("base_link", "map", 0.0)
            seen += [bench.time, await bench.truth(), repr(believed), reports.statuses, list(bench.happened)]
            if number == 3:
                await bench.cast(Simulation).spawn_entity("box", BOX, place(1.8, 0.9))
        expect(distance(await bench.truth(), (0.0, 0.0)) > 0.1, "a robot with a goal did not move")
    return seen


SUCCEEDED = GoalStatus.SUCCEEDED
NEAR = 0.3  # [m]
LONG = 20.0  # [s]


@rule(MobileRobots, Simulation)
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


@rule(MobileRobots, Simulation)
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


@rule(MobileRobots)
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


@rule(MobileRobots, DrivenRobots, Simulation)
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


@rule(MobileRobots, DrivenRobots, Simulation)
async def cancelled_watches_are_silent(bench: Bench) -> None:
    """A cancelled watch is not reported."""
    mobile, reports = bench.cast(MobileRobots), Reports()
    watch = await mobile.watch_distance(bench.robot, 0.2, reports)
    await mobile.cancel_watch(watch)
    await bench.cast(DrivenRobots).drive(bench.robot, 0.25, 0.0, 2.0, Reports())
    await bench.pass_time(2.5)
    expect(not reports.all, f"a cancelled watch was reported as {', '.join(reports.statuses)}")


@rule(MobileRobots)
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


@rule(DrivenRobots, Frames)
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


@rule(DrivenRobots, Frames)
async def robots_stand_still_after_a_run(bench: Bench) -> None:
    """Robots stop when the run ends, even in motion, and the run may be ended twice."""
    await bench.cast(DrivenRobots).drive(bench.robot, 0.25, 0.3, 30.0, Reports())
    await bench.pass_time(1.0)
    for _ in range(2):
        await bench.backend.end_run()
    await bench.pass_time(1.0)
    await bench.expect_still("a robot whose run ended 1 s ago")
