"""Rules for wheeled robots: standing, driving, stopping, and power."""

from __future__ import annotations

import math

from sim_nodes.check.bench import (
    CUBE,
    EDGE,
    ORIGIN,
    OTHER,
    ROBOT,
    WHEEL_RADIUS,
    Make,
    at,
    body,
    built,
    drive,
    expect,
    expect_near,
    expect_state,
    run,
)
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.physics import BodyState

STANDING = 2e-3  # [m], [rad]


def robots_stand_level_and_still(make: Make) -> None:
    """A robot stands where it was placed, level, with the origin of its base on the floor."""
    placed = Pose2(1.0, -2.0, 0.7)
    engine = built(make, placed)
    run(engine, 2.0)
    state = engine.body_state(ROBOT)
    wanted = BodyState((placed.x, placed.y, 0.0), quaternion(0.0, 0.0, placed.yaw))
    expect_state("a robot after 2 s", state, wanted, STANDING)
    expect_near("how far its wheels have turned [rad]", engine.wheel_angles(ROBOT), (0.0, 0.0), 0.02)


def wheels_turn_as_commanded(make: Make) -> None:
    """Each wheel turns at its commanded speed, forwards for positive values."""
    engine = built(make, ORIGIN)
    engine.command_wheels(ROBOT, 4.0, -2.0)
    run(engine, 1.0)
    before = engine.wheel_angles(ROBOT)
    run(engine, 2.0)
    after = engine.wheel_angles(ROBOT)
    turned = [b - a for a, b in zip(before, after, strict=True)]
    expect_near("the angle of the left wheel in 2 s at 4 rad/s", turned[0], 8.0, 0.4)
    expect_near("the angle of the right wheel in 2 s at -2 rad/s", turned[1], -4.0, 0.2)


def robots_drive_straight(make: Make) -> None:
    """A robot at 0.3 m/s drives 3 m in 10 s within 2 %, straight, and as far as its wheels have turned."""
    engine = built(make, Pose2(-1.0, 1.0, math.pi / 2))
    drive(engine, 0.3, 0.0, seconds=10.0)
    found, angles = engine.body_state(ROBOT), engine.wheel_angles(ROBOT)
    travelled = found.position[1] - 1.0
    expect_near("the distance in 10 s [m]", travelled, 3.0, 0.06)
    expect_near("the distance off the line [m]", found.position[0], -1.0, 0.01)
    expect_near("the heading [rad]", found.planar.yaw, math.pi / 2, 0.01)
    for side, angle in zip(("left", "right"), angles, strict=True):
        rolled = angle * WHEEL_RADIUS
        expect_near(f"the distance that the {side} wheel has rolled [m]", rolled, travelled, 0.06)
    expect_near("the velocity", found.linear, (0.0, 0.3, 0.0), 0.015)


def robots_turn_in_place(make: Make) -> None:
    """A robot that turns at 1 rad/s turns left by 3 rad in 3 s within 5 %, in place."""
    engine = built(make, ORIGIN)
    drive(engine, 0.0, 1.0, seconds=3.0)
    found = engine.body_state(ROBOT)
    expect_near("the heading after 3 s [rad]", found.planar.yaw, 3.0, 0.15)
    expect_near("the place after 3 s", found.position, (0.0, 0.0, 0.0), 0.02)
    expect_near("the rate of turning [rad/s]", found.angular[2], 1.0, 0.05)


def robots_stop_on_command(make: Make) -> None:
    """A robot at 0.3 m/s stops within 5 cm and 0.4 s, and stays level."""
    engine = built(make, ORIGIN)
    drive(engine, 0.3, 0.0, seconds=2.0)
    before = engine.body_state(ROBOT)
    drive(engine, 0.0, 0.0, seconds=0.4)
    after = engine.body_state(ROBOT)
    expect_near("the distance to stop [m]", after.position[0] - before.position[0], 0.025, 0.025)
    expect_near("the velocity after 0.4 s", after.linear, (0.0, 0.0, 0.0), 2e-3)
    expect_near("the height of the base [m]", after.position[2], 0.0, STANDING)


def robots_ignore_commands_of_others(make: Make) -> None:
    """Commands of one robot do not move others."""
    engine = built(make, ORIGIN, Pose2(2.0, 2.0, 0.0))
    drive(engine, 0.3, 0.0, OTHER, seconds=2.0)
    expect_near(
        "the place of a robot without commands", engine.body_state(ROBOT).position, (0.0, 0.0, 0.0), STANDING
    )
    driven = engine.body_state(OTHER).position[0]
    expect(driven > 2.5, f"the robot with commands is at x = {driven:.3f} m after 2 s at 0.3 m/s from x = 2 m")


def wheels_without_power_roll_freely(make: Make) -> None:
    """Wheels without power come to rest, ignore commands, can be pushed; with power, they obey the last one."""
    engine = built(make, ORIGIN, Pose2(-3.0, 3.0, 0.0))
    drive(engine, 0.3, 0.0)
    drive(engine, 0.3, 0.0, OTHER, seconds=1.0)
    engine.power_wheels(ROBOT, False)
    run(engine, 5.0)
    expect_near("the velocity 5 s after", engine.body_state(ROBOT).linear, (0.0, 0.0, 0.0), 5e-3)
    before = engine.body_state(ROBOT).position[0]
    drive(engine, -0.3, 0.0, seconds=1.0)
    expect_near("the place after another command", engine.body_state(ROBOT).position[0], before, 5e-3)
    driven = engine.body_state(OTHER).linear[0]
    expect(driven > 0.25, f"another robot is at {driven:.3f} m/s instead of 0.3 m/s")
    engine.set_body_state(ROBOT, BodyState((1.0, 0.0, 0.0), linear=(0.5, 0.0, 0.0)))
    run(engine, 0.4)
    pushed = engine.body_state(ROBOT).position[0] - 1.0
    expect(pushed > 0.03, f"a robot without power that is pushed at 0.5 m/s comes {pushed:.3f} m far in 0.4 s")
    engine.add_body("box", body(CUBE), at(3.0, 3.0, EDGE / 2))
    run(engine, 5.0)
    expect_near("its velocity after a body was added", engine.body_state(ROBOT).linear, (0.0, 0.0, 0.0), 5e-3)
    engine.power_wheels(ROBOT, True)
    run(engine, 1.0)
    expect_near("the velocity with power again", engine.body_state(ROBOT).linear[0], -0.3, 0.015)


def a_reset_switches_power_on(make: Make) -> None:
    """A reset switches the power of wheels on."""
    engine = built(make, ORIGIN)
    engine.power_wheels(ROBOT, False)
    engine.reset()
    drive(engine, 0.3, 0.0, seconds=1.0)
    expect_near("the velocity", engine.body_state(ROBOT).linear[0], 0.3, 0.015)


def a_robot_stays_where_its_state_is_set(make: Make) -> None:
    """A robot whose state is set stays there, its wheels at rest and their angles unchanged."""
    engine = built(make, ORIGIN)
    drive(engine, 0.3, 0.4, seconds=2.0)
    drive(engine, 0.0, 0.0)
    angles = engine.wheel_angles(ROBOT)
    wanted = BodyState((3.0, -2.0, 0.0), quaternion(0.0, 0.0, 2.0))
    engine.set_body_state(ROBOT, wanted)
    expect_state("a robot that was put somewhere", engine.body_state(ROBOT), wanted, 1e-9)
    expect_near("the angles of its wheels [rad]", engine.wheel_angles(ROBOT), angles, 1e-9)
    run(engine, 0.5)
    expect_state("it after 0.5 s", engine.body_state(ROBOT), wanted, STANDING)
    expect_near("the angles of its wheels after 0.5 s [rad]", engine.wheel_angles(ROBOT), angles, 0.02)
