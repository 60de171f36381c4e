"""Rules about time: it passes in grants only."""

from __future__ import annotations

import anyio

from seoro.bridges.conformance.bench import BOX, STEP, Make, Reports, distance, expect, expect_near, place, started
from seoro.runtime.capabilities import DrivenRobots, MobileRobots, Simulation

REAL = 0.1  # [s] of the machine's clock


async def time_passes_in_grants(make: Make) -> None:
    """Without anything to tell, a grant comes to where it was granted, and no more than a step beyond."""
    async with started(make) as bench:
        for until in (0.02, 0.5, 0.503, 3.0):
            await bench.grant(until)
            expect_near(f"what a grant to {until} s comes to [s]", bench.time, until, STEP)


async def time_never_goes_back(make: Make) -> None:
    """A grant of what has passed changes nothing, and says how late it is."""
    async with started(make) as bench:
        await bench.grant(1.0)
        for until in (1.0, 0.5, 0.0, -1.0):
            found = await bench.backend.advance(until)
            expect(found == bench.time, f"at {bench.time} s, a grant to {until} s came to {found} s")


async def time_stands_still_without_grants(make: Make) -> None:
    """While nothing is granted nothing moves, however long that takes, and whatever is asked meanwhile."""
    async with started(make) as bench:
        await bench.can(DrivenRobots).drive(bench.robot, 0.2, 0.0, 10.0, Reports())
        await bench.grant(1.0)
        before = await bench.truth()
        await anyio.sleep(REAL)
        after = await bench.truth()
        expect(before == after, f"the robot went from {before} to {after} while no time was granted")
        found = await bench.backend.advance(bench.time)
        expect(found == bench.time, f"the time went from {bench.time} s to {found} s without a grant")


async def requests_find_the_time_of_the_run(make: Make) -> None:
    """However time was granted before, what is asked for happens at the time to which it was granted last."""
    poses = []
    for small in (False, True):
        async with started(make) as bench:
            driving = bench.can(DrivenRobots)
            await driving.drive(bench.robot, 0.2, 0.3, 30.0, Reports())
            await bench.grant(0.1)
            for until in (1.0, 1.02, 3.0):
                while small and bench.time + 0.02 < until:
                    await bench.grant(bench.time + 0.02)
                await bench.grant(until)
                poses.append(await bench.truth())
    one, other = poses[:3], poses[3:]
    expect(one == other, f"the robot was at {other} after small grants, and at {one} after large ones")


async def grants_end_when_something_is_to_be_told(make: Make) -> None:
    """A grant ends early when what was watched for happens, and its reporter is told before that."""
    async with started(make) as bench:
        await bench.can(DrivenRobots).drive(bench.robot, 0.2, 0.0, 10.0, Reports())
        reports = Reports()
        await bench.can(MobileRobots).watch_distance(bench.robot, 0.3, reports)
        await bench.grant(30.0)
        expect(
            bench.time < 10.0, f"a grant in which the robot came as far as was watched for ended at {bench.time} s"
        )
        expect(len(reports.all) == 1, f"when the grant ended, the watch had been told {len(reports.all)} times")


async def equal_runs_are_equal_to_the_bit(make: Make) -> None:
    """Two runs with the same world, seed and requests are the same, bit for bit."""
    first, second = [await _run(make) for _ in range(2)]
    for index, (one, other) in enumerate(zip(first, second, strict=False)):
        expect(one == other, f"observation {index} is {other!r} in a second run, and {one!r} in the first")
    expect(len(first) == len(second), f"a second run has {len(second)} observations, the first {len(first)}")


async def _run(make: Make) -> list[object]:
    """What is seen of a run."""
    seen: list[object] = []
    async with started(make) as bench:
        reports = Reports()
        await bench.can(MobileRobots).set_initial_pose(bench.robot, place(0.0, 0.0))
        await bench.can(MobileRobots).navigate(bench.robot, [place(1.0, 0.5)], stop_at_each=False, report=reports)
        for number in range(10):
            await bench.grant(bench.time + 0.31)
            believed = await bench.can(Simulation).relative_pose("base_link", "map", 0.0)
            seen += [bench.time, await bench.truth(), repr(believed), reports.statuses, list(bench.happened)]
            if number == 3:
                await bench.can(Simulation).spawn_entity("box", BOX, place(1.8, 0.9))
        expect(distance(await bench.truth(), (0.0, 0.0)) > 0.1, "the robot that was sent to a goal did not move")
    return seen
