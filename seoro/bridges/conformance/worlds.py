"""Rules about entities and snapshots. A backend that cannot save snapshots has to report that."""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import (
    AT_REST,
    BOX,
    Bench,
    Reports,
    distance,
    expect,
    expect_near,
    expect_refused,
    place,
    rule,
)
from seoro.bridges.wire import Result, SpawnResult
from seoro.errors import BackendRefused
from seoro.runtime.contracts.contacts import Contact, ContactSensing
from seoro.runtime.contracts.robots import DrivenRobots, MobileRobots
from seoro.runtime.contracts.worlds import Simulation, Snapshots


@rule(Simulation)
async def spawned_entities_are_listed_until_deleted(bench: Bench) -> None:
    """A spawned entity is listed by its name until it is deleted; then the name is free again."""
    world = bench.cast(Simulation)
    for _ in range(2):
        name = await world.spawn_entity("box", BOX, place(2.0, 1.0))
        expect(name == "box", f"an entity with the name 'box' was spawned as {name!r}")
        names = await world.entities()
        expect(names.count("box") == 1, f"after a spawn, {', '.join(names)} are listed")
        expect(bench.robot in names, f"the robot {bench.robot!r} is not among {', '.join(names)}")
        await bench.pass_time(0.2)
        await world.delete_entity("box")
        expect("box" not in await world.entities(), "a deleted entity is still listed")


@rule(Simulation)
async def names_are_unique(bench: Bench) -> None:
    """A duplicate name is refused, or replaced by another one if renaming is allowed."""
    world = bench.cast(Simulation)
    await world.spawn_entity("box", BOX, place(2.0, 1.0))
    again = world.spawn_entity("box", BOX, place(2.0, -1.0))
    await expect_refused("a second entity with the same name", again, SpawnResult.NAME_NOT_UNIQUE)
    other = await world.spawn_entity("box", BOX, place(2.0, -1.0), allow_renaming=True)
    expect(other not in ("box", ""), f"a second entity that may be renamed has the name {other!r}")
    expect({"box", other} <= set(await world.entities()), f"'box' and {other!r} are not both listed")


@rule(Simulation)
async def invalid_spawns_are_refused(bench: Bench) -> None:
    """Spawns without a model, a position, a name or free space are refused, and change nothing."""
    world = bench.cast(Simulation)
    before = await world.entities()
    missing = world.spawn_entity("thing", "example_simulation://models/none.sdf", place(2.0, 0.0))
    await expect_refused("an unknown model", missing, SpawnResult.NO_RESOURCE)
    await expect_refused("a position that is not a number", world.spawn_entity("thing", BOX, place(math.nan, 0.0)))
    await expect_refused("an empty name", world.spawn_entity("", BOX, place(2.0, 0.0)))
    await expect_refused("a box inside of the robot", world.spawn_entity("thing", BOX, place(0.0, 0.0)))
    await expect_refused("the deletion of an unknown entity", world.delete_entity("thing"), Result.NOT_FOUND)
    await expect_refused("the deletion of a robot", world.delete_entity(bench.robot))
    after = await world.entities()
    expect(after == before, f"after refused requests there are {', '.join(after)} instead of {', '.join(before)}")


@rule(Simulation)
async def moved_robots_have_their_new_pose(bench: Bench) -> None:
    """A robot is at its new pose at once, and so are frames relative to it."""
    world = bench.cast(Simulation)
    await world.set_entity_state(bench.robot, place(1.0, -2.0, yaw=math.pi / 2), AT_REST)
    x, y, yaw = await bench.truth()
    for what, found, wanted in (("x [m]", x, 1.0), ("y [m]", y, -2.0), ("yaw [rad]", yaw, math.pi / 2)):
        expect_near(f"of a moved robot, {what}", found, wanted, 1e-3)
    ahead = await world.relative_pose(bench.truth_frame, "map", 0.5)
    expect_near("the y of a frame 0.5 m ahead of it [m]", ahead.position.y, -1.5, 1e-3)
    unknown = world.set_entity_state("nothing", place(0.0, 0.0), AT_REST)
    await expect_refused("a move of an unknown entity", unknown, Result.NOT_FOUND)
    frame = world.relative_pose("nowhere", "map", 0.0)
    await expect_refused("the pose of an unknown frame", frame, Result.NOT_FOUND)


@rule(Simulation, DrivenRobots)
async def contacts_are_reported(bench: Bench) -> None:
    """A collision of a robot is reported as `contact` with both names, within the grant."""
    await bench.cast(Simulation).spawn_entity("box", BOX, place(0.8, 0.0))
    await bench.pass_time(0.2)
    expect(not bench.happened, f"a box and a robot that stand apart have contacts: {bench.happened}")
    await bench.cast(DrivenRobots).drive(bench.robot, 0.25, 0.0, 10.0, Reports())
    await bench.pass_until(8.0, lambda: bool(bench.happened))
    expect(bool(bench.happened), "no contact was reported of a robot that drove against a box for seconds")
    name, arguments = bench.happened[0]
    expect(name == "contact", f"a contact is reported as {name!r} instead of 'contact'")
    both = {arguments.get("first"), arguments.get("second")}
    expect(both == {"box", bench.robot}, f"a contact of 'box' and {bench.robot!r} is reported of {both}")
    expect_near("the time of the contact [s]", float(arguments["time"]), bench.time, 1e-6)
    backend, contact = bench.backend, Contact.of(arguments)
    if isinstance(backend, ContactSensing) and backend.senses_contacts(bench.robot):
        found = contact.strikers
        expect(found == (bench.robot,), f"the strikers of a robot that drove into a standing box are {found}")
        expect(contact.position is not None, "a contact of a robot has no position")


@rule(MobileRobots, Simulation)
async def resets_restore_the_world(bench: Bench) -> None:
    """A reset restores the initial poses, deletes spawned entities, and keeps the clock running."""
    world, mobile = bench.cast(Simulation), bench.cast(MobileRobots)
    before, names = await bench.truth(), await world.entities()
    await mobile.set_initial_pose(bench.robot, place(0.0, 0.0))
    await mobile.navigate(bench.robot, [place(2.0, 0.0)], stop_at_each=False, report=Reports())
    await world.spawn_entity("box", BOX, place(-1.0, 0.0))
    await bench.pass_time(2.0)
    await world.reset_simulation()
    found = await bench.truth()
    expect(distance(found, before) < 1e-3, f"after a reset the robot is at {found} instead of {before}")
    after = await world.entities()
    expect(after == names, f"after a reset there are {', '.join(after)} instead of {', '.join(names)}")
    await bench.pass_time(1.0)
    expect_near("the time 1 s after a reset at 2 s", bench.time, 3.0, 2 * 0.05)
    await bench.expect_still("a robot whose world was reset")


@rule(Simulation, DrivenRobots, Snapshots)
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


@rule(Simulation, DrivenRobots, Snapshots)
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
