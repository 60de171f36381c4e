"""Rules about what is in the world: spawned, moved, deleted, touched, reset."""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import (
    AT_REST,
    BOX,
    Make,
    Reports,
    distance,
    expect,
    expect_near,
    expect_refused,
    place,
    started,
)
from seoro.bridges.wire import Result, SpawnResult
from seoro.runtime.capabilities import ContactSensing, DrivenRobots, MobileRobots, Simulation
from seoro.runtime.contracts import Contact


async def what_is_spawned_is_there_until_it_is_deleted(make: Make) -> None:
    """What is spawned is listed by its name until it is deleted, and the name is free again then."""
    async with started(make) as bench:
        world = bench.can(Simulation)
        for _ in range(2):
            name = await world.spawn_entity("box", BOX, place(2.0, 1.0))
            expect(name == "box", f"what was to be spawned as 'box' is called {name!r}")
            names = await world.entities()
            expect(names.count("box") == 1, f"after a spawn there are {', '.join(names)}")
            expect(bench.robot in names, f"the robot {bench.robot!r} is not among {', '.join(names)}")
            await bench.pass_time(0.2)
            await world.delete_entity("box")
            expect("box" not in await world.entities(), "what was deleted is still listed")


async def names_are_unique(make: Make) -> None:
    """A name that is taken is refused, unless another one is allowed, which is returned then."""
    async with started(make) as bench:
        world = bench.can(Simulation)
        await world.spawn_entity("box", BOX, place(2.0, 1.0))
        again = world.spawn_entity("box", BOX, place(2.0, -1.0))
        await expect_refused("a second entity of a name", again, SpawnResult.NAME_NOT_UNIQUE)
        other = await world.spawn_entity("box", BOX, place(2.0, -1.0), allow_renaming=True)
        expect(other not in ("box", ""), f"a second entity that may be renamed is called {other!r}")
        expect({"box", other} <= set(await world.entities()), f"'box' and {other!r} are not both there")


async def what_cannot_be_spawned_is_refused(make: Make) -> None:
    """Spawns without a model, a place, a name, or room for them are refused, and nothing is there."""
    async with started(make) as bench:
        world = bench.can(Simulation)
        before = await world.entities()
        missing = world.spawn_entity("thing", "example_simulation://models/none.sdf", place(2.0, 0.0))
        await expect_refused("a model that there is not", missing, SpawnResult.NO_RESOURCE)
        await expect_refused("a place that is no number", world.spawn_entity("thing", BOX, place(math.nan, 0.0)))
        await expect_refused("an empty name", world.spawn_entity("", BOX, place(2.0, 0.0)))
        await expect_refused("a box inside of the robot", world.spawn_entity("thing", BOX, place(0.0, 0.0)))
        await expect_refused("the deletion of what is not there", world.delete_entity("thing"), Result.NOT_FOUND)
        await expect_refused("the deletion of a robot", world.delete_entity(bench.robot))
        after = await world.entities()
        expect(
            after == before, f"after refused requests there are {', '.join(after)} instead of {', '.join(before)}"
        )


async def what_is_put_somewhere_is_there(make: Make) -> None:
    """A robot that is put somewhere is there at once, and places ahead of it are ahead of it."""
    async with started(make) as bench:
        world = bench.can(Simulation)
        await world.set_entity_state(bench.robot, place(1.0, -2.0, yaw=math.pi / 2), AT_REST)
        x, y, yaw = await bench.truth()
        for what, found, wanted in (("x [m]", x, 1.0), ("y [m]", y, -2.0), ("yaw [rad]", yaw, math.pi / 2)):
            expect_near(f"of a robot that was put somewhere, {what}", found, wanted, 1e-3)
        ahead = await world.relative_pose(bench.truth_frame, "map", 0.5)
        expect_near("the y of a place 0.5 m ahead of it [m]", ahead.position.y, -1.5, 1e-3)
        unknown = world.set_entity_state("nothing", place(0.0, 0.0), AT_REST)
        await expect_refused("to put what is not there somewhere", unknown, Result.NOT_FOUND)
        frame = world.relative_pose("nowhere", "map", 0.0)
        await expect_refused("the pose of an unknown frame", frame, Result.NOT_FOUND)


async def contacts_are_told(make: Make) -> None:
    """When a robot drives into something, that is told as `contact` with both names, in the grant of it."""
    async with started(make) as bench:
        await bench.can(Simulation).spawn_entity("box", BOX, place(0.8, 0.0))
        await bench.pass_time(0.2)
        expect(not bench.happened, f"a box and a robot that stand apart touch: {bench.happened}")
        await bench.can(DrivenRobots).drive(bench.robot, 0.25, 0.0, 10.0, Reports())
        await bench.pass_until(8.0, lambda: bool(bench.happened))
        expect(bool(bench.happened), "a robot drove against a box for seconds, and no contact was told")
        name, arguments = bench.happened[0]
        expect(name == "contact", f"what happened is called {name!r} instead of 'contact'")
        both = {arguments.get("first"), arguments.get("second")}
        expect(both == {"box", bench.robot}, f"a contact of 'box' and {bench.robot!r} is told of {both}")
        expect_near("the time of the contact [s]", float(arguments["time"]), bench.time, 1e-6)
        backend, contact = bench.backend, Contact.of(arguments)
        if isinstance(backend, ContactSensing) and backend.senses_contacts(bench.robot):
            found = contact.strikers
            expect(found == (bench.robot,), f"a robot that drove into a box that stands: the strikers are {found}")
            expect(contact.position is not None, "a contact of a robot has no position")


async def a_reset_puts_the_world_back(make: Make) -> None:
    """A reset puts robots back to where they began, deletes what was spawned, and lets time go on."""
    async with started(make) as bench:
        world, mobile = bench.can(Simulation), bench.can(MobileRobots)
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
        moved = distance(await bench.truth(), before)
        expect(moved < 0.01, f"a robot whose world was reset moved {moved:.3f} m by itself")
