"""Rules for engines that know the power of motors."""

from __future__ import annotations

from sim_nodes.check.bench import BASE, ORIGIN, ROBOT, WHEEL_RADIUS, Make, built, expect, expect_near, run
from sim_nodes.check.drives import PLANAR, built_drive, drive_of
from sim_nodes.physics import Engine, MeasuresPower
from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.kinematics import Velocity, motor_commands

SPEED, SPEED_STEP = 0.3, 0.02  # [m/s], [m/s] between two commands
DAMPING = 0.01  # [N m s/rad] of each of the two wheels of `TURTLEBOT`
COMMAND_PERIOD = 0.02  # [s]
STILL = 0.01  # [W]


def motors_deliver_what_damping_takes(make: Make) -> None:
    """Motors deliver the power that the damping of wheels takes, and none at rest."""
    engine = built(make, ORIGIN)
    run(engine, 1.0)
    expect_near("the power at rest [W]", _power(engine), 0.0, STILL)
    engine.command_wheels(ROBOT, *motor_commands(BASE.drive, Velocity(SPEED, 0.0)))
    run(engine, 2.0)
    damped = 2.0 * DAMPING * (SPEED / WHEEL_RADIUS) ** 2
    expect_near("the power of a robot at 0.3 m/s [W]", _power(engine), damped, 0.05 * damped)


def motors_that_brake_deliver_nothing(make: Make) -> None:
    """Motors of planar drives deliver power while the robot speeds up, and none while it brakes or coasts."""
    for kind in PLANAR:
        engine, drive = built_drive(make, kind), drive_of(kind)
        faster = _change_speed(engine, drive, 0.0, SPEED)
        expect(faster > 0.0, f"the motors of the drive {kind.value} deliver nothing while it speeds up")
        run(engine, 1.0)
        expect_near("the power at a constant speed [W]", _power(engine), 0.0, 10.0 * STILL)
        slower = _change_speed(engine, drive, SPEED, 0.0)
        expect(slower < 0.01 * faster, f"the motors deliver {slower:.3f} W while they brake")


def _power(engine: Engine) -> float:
    assert isinstance(engine, MeasuresPower)
    return engine.motor_power(ROBOT)


def _change_speed(engine: Engine, drive: DriveDeclaration, start: float, end: float) -> float:
    """Change the speed evenly [m/s]; return the mean power after each command [W]."""
    count = round(abs(end - start) / SPEED_STEP)
    total = 0.0
    for number in range(1, count + 1):
        speed = start + (end - start) * number / count
        engine.command_wheels(ROBOT, *motor_commands(drive, Velocity(speed, 0.0)))
        run(engine, COMMAND_PERIOD)
        total += _power(engine)
    return total / count
