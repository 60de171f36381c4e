"""Rules about snapshots. A backend may be unable to save anything, and has to say so."""

from __future__ import annotations

from seoro.bridges.conformance.bench import BOX, Bench, Make, Reports, expect, expect_refused, place, started
from seoro.bridges.wire import Result
from seoro.errors import BackendRefused
from seoro.runtime.capabilities import DrivenRobots, Simulation, Snapshots


async def what_was_saved_goes_on_as_it_did(make: Make) -> None:
    """What goes on from a snapshot is the same as went on from there before, and time goes on meanwhile."""
    async with started(make) as bench:
        world, snapshots = bench.can(Simulation), bench.can(Snapshots)
        await bench.can(DrivenRobots).drive(bench.robot, 0.2, 0.3, 30.0, Reports())
        await bench.pass_time(1.0)
        if not await _saves(bench):
            return
        place_then, names = await bench.truth(), await world.entities()
        first = await _follow(bench)
        await world.spawn_entity("box", BOX, place(2.0, 2.0))
        now = bench.time
        await snapshots.restore_snapshot("here", None)
        found, after = await bench.truth(), await world.entities()
        expect(found == place_then, f"restored, the robot is at {found} instead of {place_then}")
        expect(after == names, f"restored, there are {', '.join(after)} instead of {', '.join(names)}")
        expect(await bench.backend.advance(now) == now, "to restore a snapshot has changed the time of the run")
        second = await _follow(bench)
        expect(first == second, f"what follows is {second} after a snapshot was restored, and was {first}")


async def unknown_snapshots_are_refused(make: Make) -> None:
    """To restore what was not saved is refused."""
    async with started(make) as bench:
        if await _saves(bench):
            restored = bench.can(Snapshots).restore_snapshot("never saved", None)
            await expect_refused("to restore what was not saved", restored)


async def _saves(bench: Bench) -> bool:
    """Save something; False for a backend that says that it cannot."""
    try:
        await bench.can(Snapshots).save_snapshot("here")
    except BackendRefused as refused:
        if refused.code == Result.FEATURE_UNSUPPORTED and " " in str(refused):
            return False
        raise AssertionError(f"a snapshot is refused with code {refused.code}: {refused}") from refused
    return True


async def _follow(bench: Bench) -> list[tuple[float, float, float]]:
    seen = []
    for _ in range(4):
        await bench.pass_time(0.25)
        seen.append(await bench.truth())
    return seen
