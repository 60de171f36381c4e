"""Rules for engines that know the work of motors."""

from __future__ import annotations

from sim_nodes.check.bench import BASE, ORIGIN, ROBOT, WHEEL_RADIUS, Make, built, expect, expect_near, run
from sim_nodes.check.drives import PLANAR, RADIUS, built_drive, drive_of
from sim_nodes.physics import Engine, MeasuresWork
from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.kinematics import Velocity, motor_commands

SPEED, SPEED_STEP = 0.3, 0.02  # [m/s], [m/s] between two commands
DAMPING = 0.01  # [N m s/rad] of each of the two wheels of `TURTLEBOT`
COMMAND_PERIOD = 0.02  # [s]
STILL = 0.01  # [J] in a second
MASS, WHEELS, WHEEL_INERTIA = 24.0, 4, 5e-3  # [kg], and [kg m^2] of each wheel, of `robot_with`


def motors_deliver_what_damping_takes(make: Make) -> None:
    """Motors do the work that the damping of wheels takes, and none at rest."""
    engine = built(make, ORIGIN)
    run(engine, 1.0)
    rested = _measured(engine)
    run(engine, 1.0)
    expect_near("the work of a second at rest [J]", _work(engine) - rested, 0.0, STILL)
    engine.command_wheels(ROBOT, *motor_commands(BASE.drive, Velocity(SPEED, 0.0)))
    run(engine, 2.0)
    before = _work(engine)
    run(engine, 1.0)
    damped = 2.0 * DAMPING * (SPEED / WHEEL_RADIUS) ** 2
    expect_near("the work of a second at 0.3 m/s [J]", _work(engine) - before, damped, 0.05 * damped)


def motors_deliver_the_kinetic_energy(make: Make) -> None:
    """The work of motors that speed up a planar drive is its kinetic energy within 1 %, and braking adds none."""
    for kind in PLANAR:
        engine, drive = built_drive(make, kind), drive_of(kind)
        run(engine, 1.0)
        rested = _measured(engine)
        _change_speed(engine, drive, 0.0, SPEED)
        faster = _work(engine) - rested
        least, most = (_kinetic_energy(drive, armature) for armature in (0.0, drive.armature))
        expect(
            0.99 * least <= faster <= 1.01 * most,
            f"the motors of the drive {kind.value} do {faster:.3f} J of work, not {least:.3f} to {most:.3f} J",
        )
        run(engine, 1.0)
        expect_near("the work at a constant speed [J]", _work(engine) - rested, faster, STILL)
        _change_speed(engine, drive, SPEED, 0.0)
        slower = _work(engine) - rested - faster
        expect(slower < 0.02 * faster, f"the motors do {slower:.3f} J of work while they brake")


def _kinetic_energy(drive: DriveDeclaration, armature: float) -> float:
    """Return the kinetic energy at `SPEED`, with an armature of each wheel that the engine may simulate [J]."""
    rolling = WHEELS * (WHEEL_INERTIA + armature) * (SPEED / RADIUS) ** 2
    return 0.5 * (MASS * SPEED**2 + rolling)


def _measured(engine: Engine) -> float:
    """Begin to measure the work of the robot, and return that before [J]."""
    assert isinstance(engine, MeasuresWork)
    engine.measure_work(ROBOT)
    return engine.motor_work(ROBOT)


def _work(engine: Engine) -> float:
    assert isinstance(engine, MeasuresWork)
    return engine.motor_work(ROBOT)


def _change_speed(engine: Engine, drive: DriveDeclaration, start: float, end: float) -> None:
    """Change the speed evenly [m/s]."""
    count = round(abs(end - start) / SPEED_STEP)
    for number in range(1, count + 1):
        speed = start + (end - start) * number / count
        engine.command_wheels(ROBOT, *motor_commands(drive, Velocity(speed, 0.0)))
        run(engine, COMMAND_PERIOD)
    run(engine, 0.5)
