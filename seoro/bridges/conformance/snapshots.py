"""Rules about snapshots. A backend that cannot save them has to report that."""

from __future__ import annotations

from seoro.bridges.conformance.bench import BOX, Bench, Reports, expect, expect_refused, place
from seoro.bridges.wire import Result
from seoro.errors import BackendRefused
from seoro.runtime.contracts.robots import DrivenRobots
from seoro.runtime.contracts.worlds import Simulation, Snapshots


async def restored_runs_repeat_the_original(bench: Bench) -> None:
    """A run restored from a snapshot repeats the original, while its time continues."""
    world, snapshots = bench.cast(Simulation), bench.cast(Snapshots)
    await bench.cast(DrivenRobots).drive(bench.robot, 0.2, 0.3, 30.0, Reports())
    await bench.pass_time(1.0)
    if not await _saves(bench):
        return
    place_then, names = await bench.truth(), await world.entities()
    first = await _follow(bench)
    await world.spawn_entity("box", BOX, place(2.0, 2.0))
    now = bench.time
    await snapshots.restore_snapshot("here", None)
    found, after = await bench.truth(), await world.entities()
    expect(found == place_then, f"a restored robot is at {found} instead of {place_then}")
    expect(after == names, f"a restored world has {', '.join(after)} instead of {', '.join(names)}")
    expect(
        await bench.backend.advance(now) == now, "the restoration of a snapshot has changed the time of the run"
    )
    second = await _follow(bench)
    expect(first == second, f"after a restoration follows {second} instead of {first}")


async def unknown_snapshots_are_refused(bench: Bench) -> None:
    """The restoration of an unknown snapshot is refused."""
    if await _saves(bench):
        restored = bench.cast(Snapshots).restore_snapshot("never saved", None)
        await expect_refused("the restoration of an unknown snapshot", restored)


async def _saves(bench: Bench) -> bool:
    """Save a snapshot; False for a backend that does not support it."""
    try:
        await bench.cast(Snapshots).save_snapshot("here")
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
