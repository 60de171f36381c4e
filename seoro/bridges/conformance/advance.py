"""Rules about time, which passes in grants only."""

from __future__ import annotations

import anyio

from seoro.bridges.conformance.bench import (
    BOX,
    STEP,
    Bench,
    Make,
    Reports,
    distance,
    expect,
    expect_near,
    place,
    started,
)
from seoro.runtime.contracts.robots import DrivenRobots, MobileRobots
from seoro.runtime.contracts.worlds import Simulation

PAUSE = 0.1  # [s] of the machine's clock


async def time_passes_in_grants(bench: Bench) -> None:
    """Without events, a grant reaches its time, and at most a step beyond."""
    for until in (0.02, 0.5, 0.503, 3.0):
        await bench.grant(until)
        expect_near(f"the reached time of a grant to {until} s [s]", bench.time, until, STEP)


async def time_never_goes_back(bench: Bench) -> None:
    """A grant of a past time changes nothing, and returns the present time."""
    await bench.grant(1.0)
    for until in (1.0, 0.5, 0.0, -1.0):
        found = await bench.backend.advance(until)
        expect(found == bench.time, f"at {bench.time} s, a grant to {until} s reached {found} s")


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


async def grants_end_at_events(bench: Bench) -> None:
    """A grant ends early at the first event, and returns after the event's report."""
    await bench.cast(DrivenRobots).drive(bench.robot, 0.2, 0.0, 10.0, Reports())
    reports = Reports()
    await bench.cast(MobileRobots).watch_distance(bench.robot, 0.3, reports)
    await bench.grant(30.0)
    expect(bench.time < 10.0, f"a grant in which a watch fired ended at {bench.time} s")
    number = len(reports.all)
    expect(number == 1, f"at the end of a grant, its fired watch had {number} reports")


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
