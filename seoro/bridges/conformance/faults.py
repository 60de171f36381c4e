"""Rules about faults of sensors and motors: that they take effect is measured, by the backend and here.

Devices are sensors but for `motors` and `robot`; the rules take the power from the first sensor that sends
samples, and from the motors.
"""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import (
    Bench,
    Make,
    Reports,
    distance,
    expect,
    expect_refused,
    expect_reported,
    started,
)
from seoro.bridges.wire import Result
from seoro.runtime.capabilities import DrivenRobots, Faults, Sensors
from seoro.runtime.contracts import GoalStatus
from seoro.runtime.device_faults import MessageLoss, PowerLoss, WheelSlip

MOTORS = "motors"
NO_SENSORS = (MOTORS, "robot")
PATIENCE = 2.0  # [s] in which a sensor that works sends a sample
LIMIT = 10.0  # [s] in which a fault of the rules has to be found to take effect


async def faults_take_effect_until_they_are_cleared(make: Make) -> None:
    """A sensor whose power is cut is reported once to be silent, and is, until its faults are cleared."""
    async with started(make) as bench:
        sensor = await _sensor(bench)
        faults, reports = bench.can(Faults), Reports()
        await faults.inject_fault(bench.robot, sensor, PowerLoss(), LIMIT, reports)
        await bench.pass_until(bench.time + LIMIT + 1.0, reports.any)
        expect_reported(f"a loss of power of {sensor!r}", reports, GoalStatus.SUCCEEDED)
        said = reports.all[0].message
        expect(" " in said, f"what was measured of a fault is reported as {said!r}, which is no sentence")
        expect(not await _sends(bench, sensor), f"{sensor!r} has no power, and sends samples")
        await faults.clear_faults(bench.robot, "")
        expect(await _sends(bench, sensor), f"the faults of {sensor!r} were cleared, and it sends nothing")
        expect_reported("a fault that has taken effect", reports, GoalStatus.SUCCEEDED)


async def motors_without_power_do_not_drive(make: Make) -> None:
    """A robot whose motors have lost their power does not drive, until that is cleared."""
    async with started(make) as bench:
        faults, driven, reports = bench.can(Faults), bench.can(DrivenRobots), Reports()
        if MOTORS not in faults.devices()[bench.robot]:
            return
        await faults.inject_fault(bench.robot, MOTORS, PowerLoss(), LIMIT, reports)
        goal = await driven.drive(bench.robot, 0.2, 0.0, LIMIT, Reports())
        await bench.pass_until(bench.time + LIMIT + 1.0, reports.any)
        expect_reported("a loss of power of the motors of a robot that is driven", reports, GoalStatus.SUCCEEDED)
        for what, moves in (("without power", False), ("whose power is back", True)):
            await driven.cancel_goal(goal)
            before = await bench.truth()
            goal = await driven.drive(bench.robot, 0.2, 0.0, 1.0, Reports())
            await bench.pass_time(1.2)
            went = distance(before, await bench.truth())
            expect((went > 0.1) == moves, f"a robot {what} that is driven at 0.2 m/s for 1 s goes {went:.3f} m")
            await faults.clear_faults(bench.robot, MOTORS, PowerLoss)


async def faults_that_cannot_be_found_are_given_up(make: Make) -> None:
    """What is not found to take effect is reported once as aborted, with what was measured, and cleared."""
    async with started(make) as bench:
        sensor = await _sensor(bench)
        reports = Reports()
        await bench.can(Faults).inject_fault(bench.robot, sensor, PowerLoss(), 0.001, reports)
        await bench.pass_until(bench.time + PATIENCE, reports.any)
        expect_reported("a fault that nobody could find in 1 ms", reports, GoalStatus.ABORTED)
        expect(
            " " in reports.all[0].message, "a fault that was not found to take effect is given up without a word"
        )
        expect(await _sends(bench, sensor), f"a fault of {sensor!r} was given up, and is still there")
        expect_reported("a fault that was given up", reports, GoalStatus.ABORTED)


async def cancelled_faults_are_cleared(make: Make) -> None:
    """A fault whose measurement is cancelled is cleared; one that has taken effect stays."""
    async with started(make) as bench:
        sensor = await _sensor(bench)
        faults, reports = bench.can(Faults), Reports()
        measurement = await faults.inject_fault(bench.robot, sensor, PowerLoss(), LIMIT, reports)
        await faults.cancel_fault(measurement)
        expect(await _sends(bench, sensor), f"a fault of {sensor!r} was cancelled, and is still there")
        expect(reports.statuses in ([], ["canceled"]), f"a cancelled fault was reported as {reports.statuses}")
        again = Reports()
        measurement = await faults.inject_fault(bench.robot, sensor, PowerLoss(), LIMIT, again)
        await bench.pass_until(bench.time + LIMIT + 1.0, again.any)
        expect_reported(f"a loss of power of {sensor!r}", again, GoalStatus.SUCCEEDED)
        await faults.cancel_fault(measurement)
        expect(
            not await _sends(bench, sensor), "a fault is gone, since its measurement was cancelled after its end"
        )


async def impossible_faults_are_refused(make: Make) -> None:
    """Faults of nobody, of unknown devices, with impossible amounts or limits, or that do not fit are refused."""
    async with started(make) as bench:
        sensor = await _sensor(bench)
        faults = bench.can(Faults)
        loss = PowerLoss()
        for what, robot, device, fault, limit, code in (
            ("a fault of an unknown robot", "nobody", sensor, loss, LIMIT, Result.NOT_FOUND),
            ("a fault of an unknown device", bench.robot, "nothing", loss, LIMIT, Result.NOT_FOUND),
            ("a fault that is to be found in no time", bench.robot, sensor, loss, 0.0, None),
            ("a fault that is to be found in NaN s", bench.robot, sensor, loss, math.nan, None),
            ("a probability of 2", bench.robot, sensor, MessageLoss(2.0), LIMIT, None),
            ("wheels of a sensor that slip", bench.robot, sensor, WheelSlip(0.5, 0.5), LIMIT, None),
        ):
            request = faults.inject_fault(robot, device, fault, limit, Reports())
            await expect_refused(what, request, code)
        cleared = faults.clear_faults("nobody", "")
        await expect_refused("to clear the faults of an unknown robot", cleared, Result.NOT_FOUND)
        cleared = faults.clear_faults(bench.robot, "nothing")
        await expect_refused("to clear the faults of an unknown device", cleared, Result.NOT_FOUND)
        expect(await _sends(bench, sensor), f"after refused faults {sensor!r} sends nothing")


async def _sensor(bench: Bench) -> str:
    """The first device that sends samples."""
    devices = bench.can(Faults).devices().get(bench.robot, ())
    for device in devices:
        if device not in NO_SENSORS and await _sends(bench, device):
            return device
    raise AssertionError(f"none of the devices of {bench.robot!r} sends samples: it has {', '.join(devices)}")


async def _sends(bench: Bench, sensor: str) -> bool:
    """Whether a sample of a sensor arrives."""
    reports, sensors = Reports(), bench.can(Sensors)
    watch = await sensors.watch_sample(bench.robot, sensor, reports)
    await bench.pass_until(bench.time + PATIENCE, reports.any)
    await sensors.cancel_sensor_watch(watch)
    return reports.any()
