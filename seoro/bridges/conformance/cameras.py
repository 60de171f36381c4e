"""Rules about cameras. A backend may be unable to draw, and has to say so."""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import BOX, Bench, Make, expect, expect_refused, place, started
from seoro.bridges.wire import Result, SpawnResult
from seoro.errors import BackendRefused
from seoro.runtime.capabilities import Cameras, Image, Simulation
from seoro.runtime.contracts import Position3D

EYE = "eye"
FIELD_OF_VIEW = math.radians(60)
SIZE = 96, 64  # [pixels]
NOT_FOUND = Result.NOT_FOUND
PLACE = place(-1.5, -1.5, 1.2)
SIGNATURE = b"\x89PNG\r\n\x1a\n"  # with which files of PNG begin (ISO/IEC 15948, 5.2), before a header of 25 bytes
HEADER = len(SIGNATURE) + 25


async def pictures_have_the_size_that_was_asked_for(make: Make) -> None:
    """A picture is a PNG of as many pixels as the camera has, taken now, and taking it moves no time."""
    async with started(make) as bench:
        await bench.pass_time(0.2)
        await _spawn(bench)
        image = await _picture(bench)
        if image is None:
            return
        said = image.width, image.height
        expect(said == SIZE, f"a picture of a camera with {SIZE} pixels is said to have {said}")
        found = _size(image.png)
        expect(found == SIZE, f"a picture of a camera with {SIZE} pixels is {found or 'no PNG'}")
        expect(image.time == bench.time, f"a picture that was taken at {bench.time} s says {image.time} s")
        time = await bench.backend.advance(bench.time)
        expect(time == bench.time, f"to take a picture took time, from {bench.time} s to {time} s")


async def what_stays_as_it_is_looks_the_same(make: Make) -> None:
    """Pictures of the same are the same, byte for byte, at once and in another run."""
    taken = []
    for _ in range(2):
        async with started(make) as bench:
            await _spawn(bench)
            for _ in range(2):
                image = await _picture(bench)
                if image is None:
                    return
                taken.append(image)
    expect(taken[0] == taken[1], "two pictures of one camera are different, although nothing has happened")
    expect(taken[0] == taken[2], "a picture is another one in a second run")


async def cameras_see_what_changes(make: Make) -> None:
    """A camera that is moved or turned sees something else, as does one before which something is spawned."""
    async with started(make) as bench:
        cameras = bench.can(Cameras)
        await _spawn(bench)
        first = await _picture(bench)
        if first is None:
            return
        seen = {first.png: "first"}

        async def look(how: str) -> None:
            image = await cameras.take_picture(EYE)
            same = seen.get(image.png)
            expect(same is None, f"a camera sees the same {how} as {same}")
            seen[image.png] = how

        await bench.can(Simulation).spawn_entity("box", BOX, place(0.8, 0.6))
        await look("when a box was spawned before it")
        await cameras.place_camera(EYE, place(-2.5, 0.0, 1.0))
        await look("where it was put")
        await cameras.aim_camera(EYE, Position3D(0.8, 0.6, 0.1))
        await look("when it was aimed")
        await cameras.follow_entity(EYE, "box", Position3D(-1.0, -1.0, 1.0))
        await look("when it follows something")


async def cameras_are_there_until_they_are_deleted(make: Make) -> None:
    """A camera is listed by its name, which nothing else can have, until it is deleted."""
    async with started(make) as bench:
        cameras = bench.can(Cameras)
        for _ in range(2):
            await _spawn(bench)
            names = await cameras.cameras()
            expect(names.count(EYE) == 1, f"after a camera was spawned there are {', '.join(names)}")
            again = cameras.spawn_camera(EYE, PLACE, FIELD_OF_VIEW, *SIZE)
            await expect_refused("a second camera of a name", again, SpawnResult.NAME_NOT_UNIQUE)
            await cameras.delete_camera(EYE)
            expect(EYE not in await cameras.cameras(), "a camera that was deleted is still listed")
            await expect_refused("the deletion of a camera that is gone", cameras.delete_camera(EYE))


async def unknown_cameras_are_refused(make: Make) -> None:
    """What is asked of a camera that is not there is refused, and so are cameras that nothing can be seen with."""
    async with started(make) as bench:
        cameras = bench.can(Cameras)
        before = await cameras.cameras()
        unknown = "blind"
        await expect_refused("a picture of an unknown camera", cameras.take_picture(unknown), NOT_FOUND)
        await expect_refused("to put an unknown camera somewhere", cameras.place_camera(unknown, PLACE), NOT_FOUND)
        await expect_refused("to aim an unknown camera", cameras.aim_camera(unknown, Position3D()), NOT_FOUND)
        follow = cameras.follow_entity(unknown, bench.robot, Position3D(1.0))
        await expect_refused("an unknown camera that is to follow a robot", follow, NOT_FOUND)
        await expect_refused("the deletion of an unknown camera", cameras.delete_camera(unknown), NOT_FOUND)
        for fov, width, height in ((0.0, *SIZE), (7.0, *SIZE), (math.nan, *SIZE), (1.0, 0, 64), (1.0, 64, 10**6)):
            spawned = cameras.spawn_camera(EYE, PLACE, fov, width, height)
            await expect_refused(f"a camera of {fov} rad with {width} by {height} pixels", spawned)
        nowhere = cameras.spawn_camera(EYE, place(math.nan, 0.0), FIELD_OF_VIEW, *SIZE)
        await expect_refused("a camera at a place that is no number", nowhere)
        after = await cameras.cameras()
        expect(
            after == before, f"after refused requests there are {', '.join(after)} instead of {', '.join(before)}"
        )


async def _spawn(bench: Bench) -> None:
    """Spawn a camera that looks at where the robot begins."""
    cameras = bench.can(Cameras)
    name = await cameras.spawn_camera(EYE, PLACE, FIELD_OF_VIEW, *SIZE)
    expect(name == EYE, f"what was to be spawned as {EYE!r} is called {name!r}")
    await cameras.aim_camera(EYE, Position3D())


async def _picture(bench: Bench) -> Image | None:
    """A picture of the camera; None of a backend that says that it cannot draw."""
    try:
        return await bench.can(Cameras).take_picture(EYE)
    except BackendRefused as refused:
        if refused.code == Result.FEATURE_UNSUPPORTED and " " in str(refused):
            return None
        raise AssertionError(f"a picture is refused with code {refused.code}: {refused}") from refused


def _size(png: bytes) -> tuple[int, int] | None:
    """The size of a picture in PNG [pixels]; None for what is none (ISO/IEC 15948, 11.2.2)."""
    if not png.startswith(SIGNATURE) or png[12:16] != b"IHDR" or len(png) < HEADER:
        return None
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")
