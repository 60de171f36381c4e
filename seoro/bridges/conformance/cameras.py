"""Rules about cameras. A backend that cannot draw has to report that."""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import BOX, Bench, Make, expect, expect_refused, place, started
from seoro.bridges.wire import Result, SpawnResult
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Position3D
from seoro.runtime.contracts.sensors import Cameras, Image
from seoro.runtime.contracts.worlds import Simulation

EYE = "eye"
FIELD_OF_VIEW = math.radians(60)
SIZE = 96, 64  # [pixels]
NOT_FOUND = Result.NOT_FOUND
PLACE = place(-1.5, -1.5, 1.2)
SIGNATURE = b"\x89PNG\r\n\x1a\n"  # of PNG files (ISO/IEC 15948, 5.2), before a header of 25 bytes
HEADER = len(SIGNATURE) + 25


async def pictures_have_the_requested_size(bench: Bench) -> None:
    """A picture is a PNG with the size of its camera and the present time, and taking it takes no time."""
    await bench.pass_time(0.2)
    await _spawn(bench)
    image = await _picture(bench)
    if image is None:
        return
    size = image.width, image.height
    expect(size == SIZE, f"a picture of a camera with {SIZE} pixels is reported with {size}")
    found = _size(image.png)
    expect(found == SIZE, f"a picture of a camera with {SIZE} pixels is {found or 'an invalid PNG'}")
    expect(image.time == bench.time, f"a picture taken at {bench.time} s has the time {image.time} s")
    time = await bench.backend.advance(bench.time)
    expect(time == bench.time, f"a picture took time, from {bench.time} s to {time} s")


async def pictures_are_reproducible(make: Make) -> None:
    """Pictures of an unchanged world are identical, byte for byte, also in another run."""
    taken = []
    for _ in range(2):
        async with started(make) as bench:
            await _spawn(bench)
            for _ in range(2):
                image = await _picture(bench)
                if image is None:
                    return
                taken.append(image)
    expect(taken[0] == taken[1], "two pictures of a camera differ, although nothing has changed")
    expect(taken[0] == taken[2], "a picture differs in a second run")


async def cameras_see_changes(bench: Bench) -> None:
    """The picture of a camera changes when the camera moves or turns, or when a box is spawned in its view."""
    cameras = bench.cast(Cameras)
    await _spawn(bench)
    first = await _picture(bench)
    if first is None:
        return
    seen = {first.png: "first"}

    async def expect_changed(when: str) -> None:
        image = await cameras.take_picture(EYE)
        same = seen.get(image.png)
        expect(same is None, f"a camera has the same picture {when} as {same}")
        seen[image.png] = when

    await bench.cast(Simulation).spawn_entity("box", BOX, place(0.8, 0.6))
    await expect_changed("after a spawn in its view")
    await cameras.place_camera(EYE, place(-2.5, 0.0, 1.0))
    await expect_changed("after a move")
    await cameras.aim_camera(EYE, Position3D(0.8, 0.6, 0.1))
    await expect_changed("after it was aimed")
    await cameras.follow_entity(EYE, "box", Position3D(-1.0, -1.0, 1.0))
    await expect_changed("when it follows an entity")


async def cameras_are_listed_until_deleted(bench: Bench) -> None:
    """A camera is listed by its unique name until it is deleted."""
    cameras = bench.cast(Cameras)
    for _ in range(2):
        await _spawn(bench)
        names = await cameras.cameras()
        expect(names.count(EYE) == 1, f"after the spawn of a camera, {', '.join(names)} are listed")
        again = cameras.spawn_camera(EYE, PLACE, FIELD_OF_VIEW, *SIZE)
        await expect_refused("a second camera with the same name", again, SpawnResult.NAME_NOT_UNIQUE)
        await cameras.delete_camera(EYE)
        expect(EYE not in await cameras.cameras(), "a deleted camera is still listed")
        await expect_refused("the second deletion of a camera", cameras.delete_camera(EYE))


async def unknown_cameras_are_refused(bench: Bench) -> None:
    """Requests to unknown cameras, and cameras with invalid parameters, are refused."""
    cameras = bench.cast(Cameras)
    before = await cameras.cameras()
    unknown = "unknown"
    await expect_refused("a picture of an unknown camera", cameras.take_picture(unknown), NOT_FOUND)
    await expect_refused("a move of an unknown camera", cameras.place_camera(unknown, PLACE), NOT_FOUND)
    await expect_refused("the aiming of an unknown camera", cameras.aim_camera(unknown, Position3D()), NOT_FOUND)
    follow = cameras.follow_entity(unknown, bench.robot, Position3D(1.0))
    await expect_refused("the following of a robot by an unknown camera", follow, NOT_FOUND)
    await expect_refused("the deletion of an unknown camera", cameras.delete_camera(unknown), NOT_FOUND)
    for fov, width, height in ((0.0, *SIZE), (7.0, *SIZE), (math.nan, *SIZE), (1.0, 0, 64), (1.0, 64, 10**6)):
        spawned = cameras.spawn_camera(EYE, PLACE, fov, width, height)
        await expect_refused(f"a camera of {fov} rad with {width} by {height} pixels", spawned)
    nowhere = cameras.spawn_camera(EYE, place(math.nan, 0.0), FIELD_OF_VIEW, *SIZE)
    await expect_refused("a camera at a position that is not a number", nowhere)
    after = await cameras.cameras()
    expect(after == before, f"after refused requests there are {', '.join(after)} instead of {', '.join(before)}")


async def _spawn(bench: Bench) -> None:
    """Spawn a camera that looks at the start of the robot."""
    cameras = bench.cast(Cameras)
    name = await cameras.spawn_camera(EYE, PLACE, FIELD_OF_VIEW, *SIZE)
    expect(name == EYE, f"a camera with the name {EYE!r} was spawned as {name!r}")
    await cameras.aim_camera(EYE, Position3D())


async def _picture(bench: Bench) -> Image | None:
    """Return a picture of the camera; None if the backend cannot draw."""
    try:
        return await bench.cast(Cameras).take_picture(EYE)
    except BackendRefused as refused:
        if refused.code == Result.FEATURE_UNSUPPORTED and " " in str(refused):
            return None
        raise AssertionError(f"a picture is refused with code {refused.code}: {refused}") from refused


def _size(png: bytes) -> tuple[int, int] | None:
    """Return the size of a picture in PNG [pixels]; None if it is invalid (ISO/IEC 15948, 11.2.2)."""
    if not png.startswith(SIGNATURE) or png[12:16] != b"IHDR" or len(png) < HEADER:
        return None
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")
