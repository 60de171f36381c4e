"""Rules about faults of sensors and motors, whose effect both the backend and the rules measure.

All devices but `motors` and `robot` are sensors. The faults are a loss of power of the motors, and of the first
sensor that sends samples.
"""

from __future__ import annotations

import math

from seoro.bridges.conformance.bench import (
    Bench,
    Reports,
    distance,
    expect,
    expect_cancelled,
    expect_refused,
    expect_reported,
)
from seoro.bridges.wire import Result
from seoro.robotics.faults import MessageLoss, PowerLoss, WheelSlip
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.robots import DrivenRobots
from seoro.runtime.contracts.sensors import Faults, Sensors

MOTORS = "motors"
NO_SENSORS = (MOTORS, "robot")
PATIENCE = 2.0  # [s] time limit of a working sensor to send a sample
LIMIT = 10.0  # [s] time limit to measure the effect of a fault


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
