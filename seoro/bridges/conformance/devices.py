"""Rules about cameras, and about faults of sensors and motors.

A backend that cannot draw has to report that. Effects of faults are measured by the backend and by the rules. All
devices but `motors` and `robot` are sensors. The faults are a loss of power of the motors, and of the first sensor
that sends samples.
"""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import (
    BOX,
    Bench,
    Make,
    Reports,
    distance,
    expect,
    expect_cancelled,
    expect_refused,
    expect_reported,
    place,
    rule,
    started,
)
from seoro.bridges.wire import Result, SpawnResult
from seoro.errors import BackendRefused
from seoro.robotics.faults import MessageLoss, PowerLoss, WheelSlip
from seoro.robotics.geometry import Position3D
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.robots import DrivenRobots
from seoro.runtime.contracts.sensors import Cameras, Faults, Image, Sensors
from seoro.runtime.contracts.worlds import Simulation

EYE = "eye"
FIELD_OF_VIEW = math.radians(60)
SIZE = 96, 64  # [pixels]
NOT_FOUND = Result.NOT_FOUND
PLACE = place(-1.5, -1.5, 1.2)
SIGNATURE = b"\x89PNG\r\n\x1a\n"  # of PNG files (ISO/IEC 15948, 5.2), before a header of 25 bytes
HEADER = len(SIGNATURE) + 25


@rule(Cameras)
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


@rule(Cameras)
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


@rule(Cameras, Simulation)
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


@rule(Cameras)
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


@rule(Cameras)
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


MOTORS = "motors"
NO_SENSORS = (MOTORS, "robot")
PATIENCE = 2.0  # [s] time limit of a working sensor to send a sample
LIMIT = 10.0  # [s] time limit to measure the effect of a fault


@rule(Faults, Sensors)
async def faults_take_effect_until_they_are_cleared(bench: Bench) -> None:
    """A sensor without power is reported as silent once, and sends nothing until its faults are cleared."""
    sensor = await _sensor(bench)
    faults, reports = bench.cast(Faults), Reports()
    await faults.inject_fault(bench.robot, sensor, PowerLoss(), LIMIT, reports)
    await bench.expect_end(f"a loss of power of {sensor!r}", reports, LIMIT + 1.0)
    message = reports.all[0].message
    expect(" " in message, f"the measured effect is reported as {message!r}, which is not a sentence")
    expect(not await _sends(bench, sensor), f"{sensor!r} has no power, but sends samples")
    await faults.clear_faults(bench.robot, "")
    expect(await _sends(bench, sensor), f"the faults of {sensor!r} were cleared, but it sends nothing")
    expect_reported("a fault that has taken effect", reports, GoalStatus.SUCCEEDED)


@rule(Faults, DrivenRobots, Simulation)
async def motors_without_power_do_not_drive(bench: Bench) -> None:
    """A robot whose motors have no power does not drive until the fault is cleared."""
    faults, driven, reports = bench.cast(Faults), bench.cast(DrivenRobots), Reports()
    if MOTORS not in faults.devices()[bench.robot]:
        return
    await faults.inject_fault(bench.robot, MOTORS, PowerLoss(), LIMIT, reports)
    goal = await driven.drive(bench.robot, 0.2, 0.0, LIMIT, Reports())
    await bench.expect_end("a loss of power of the motors of a driven robot", reports, LIMIT + 1.0)
    for what, moves in (("without power", False), ("with restored power", True)):
        await driven.cancel_goal(goal)
        before = await bench.truth()
        goal = await driven.drive(bench.robot, 0.2, 0.0, 1.0, Reports())
        await bench.pass_time(1.2)
        went = distance(before, await bench.truth())
        expect((went > 0.1) == moves, f"a robot {what} that is driven at 0.2 m/s for 1 s moves {went:.3f} m")
        await faults.clear_faults(bench.robot, MOTORS, PowerLoss)


@rule(Faults, Sensors)
async def faults_without_effect_are_aborted(bench: Bench) -> None:
    """A fault without a measured effect is reported once as aborted, with the measured value, and cleared."""
    sensor = await _sensor(bench)
    reports = Reports()
    await bench.cast(Faults).inject_fault(bench.robot, sensor, PowerLoss(), 0.001, reports)
    await bench.pass_until(bench.time + PATIENCE, reports.any)
    expect_reported("a fault without an effect within 1 ms", reports, GoalStatus.ABORTED)
    expect(" " in reports.all[0].message, "a fault without an effect is aborted without a message")
    expect(await _sends(bench, sensor), f"an aborted fault of {sensor!r} is still active")
    expect_reported("an aborted fault", reports, GoalStatus.ABORTED)


@rule(Faults, Sensors)
async def cancelled_faults_are_cleared(bench: Bench) -> None:
    """A fault whose measurement is cancelled is cleared, unless its effect was measured before."""
    sensor = await _sensor(bench)
    faults, reports = bench.cast(Faults), Reports()
    measurement = await faults.inject_fault(bench.robot, sensor, PowerLoss(), LIMIT, reports)
    await faults.cancel_fault(measurement)
    expect(await _sends(bench, sensor), f"a cancelled fault of {sensor!r} is still active")
    expect_cancelled("a cancelled fault", reports)
    again = Reports()
    measurement = await faults.inject_fault(bench.robot, sensor, PowerLoss(), LIMIT, again)
    await bench.expect_end(f"a loss of power of {sensor!r}", again, LIMIT + 1.0)
    await faults.cancel_fault(measurement)
    expect(
        not await _sends(bench, sensor), "a fault was cleared by a cancellation after the end of its measurement"
    )


@rule(Faults, Sensors)
async def impossible_faults_are_refused(bench: Bench) -> None:
    """Faults of unknown robots or devices, with invalid amounts or limits, or of a wrong kind are refused."""
    sensor = await _sensor(bench)
    faults = bench.cast(Faults)
    loss = PowerLoss()
    for what, robot, device, fault, limit, code in (
        ("a fault of an unknown robot", "nobody", sensor, loss, LIMIT, Result.NOT_FOUND),
        ("a fault of an unknown device", bench.robot, "nothing", loss, LIMIT, Result.NOT_FOUND),
        ("a fault with a limit of 0 s", bench.robot, sensor, loss, 0.0, None),
        ("a fault with a limit of NaN s", bench.robot, sensor, loss, math.nan, None),
        ("a probability of 2", bench.robot, sensor, MessageLoss(2.0), LIMIT, None),
        ("slipping wheels of a sensor", bench.robot, sensor, WheelSlip(0.5, 0.5), LIMIT, None),
    ):
        request = faults.inject_fault(robot, device, fault, limit, Reports())
        await expect_refused(what, request, code)
    cleared = faults.clear_faults("nobody", "")
    await expect_refused("the clearing of faults of an unknown robot", cleared, Result.NOT_FOUND)
    cleared = faults.clear_faults(bench.robot, "nothing")
    await expect_refused("the clearing of faults of an unknown device", cleared, Result.NOT_FOUND)
    expect(await _sends(bench, sensor), f"{sensor!r} sends nothing after refused faults")


async def _sensor(bench: Bench) -> str:
    """Return the first sensor that sends samples."""
    devices = bench.cast(Faults).devices().get(bench.robot, ())
    for device in devices:
        if device not in NO_SENSORS and await _sends(bench, device):
            return device
    raise AssertionError(f"no device of {bench.robot!r} sends samples (devices: {', '.join(devices)})")


async def _sends(bench: Bench, sensor: str) -> bool:
    """Return whether a sensor sends a sample."""
    reports, sensors = Reports(), bench.cast(Sensors)
    watch = await sensors.watch_sample(bench.robot, sensor, reports)
    await bench.pass_until(bench.time + PATIENCE, reports.any)
    await sensors.cancel_sensor_watch(watch)
    return reports.any()
