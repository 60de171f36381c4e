"""Rules for drives whose wheels skid, have rollers, or steer."""

from __future__ import annotations

import math
from functools import cache

from sim_nodes.check.bench import EXTENT, ORIGIN, ROBOT, Make, expect, expect_near, run
from sim_nodes.geometry import Pose2
from sim_nodes.physics import Engine, PlacedRobot, Scene
from sim_nodes.robots.declaration import MobileDeclaration, OdometryDeclaration, RobotDeclaration
from sim_nodes.robots.drive_declaration import DriveKind, PlanarDrive, WheelDeclaration
from sim_nodes.robots.kinematics import Velocity, base_motion, motor_commands

RADIUS, HALF_TRACK, WHEELBASE = 0.1, 0.25, 0.5  # [m]
MECANUM = math.pi / 4  # [rad]
TURNING_RADIUS = 0.7  # [m]
EXACT = OdometryDeclaration(distance_noise=0.0, turn_noise=0.0, drift_noise=0.0)


@cache
def robot_with(kind: DriveKind) -> RobotDeclaration:
    """Return a robot of 24 kg with four wheels and a drive of a kind; it has no sensors."""
    rear = 0.0 if kind is DriveKind.ACKERMANN else -WHEELBASE / 2
    wheels, links, joints = [], [], []
    for axle, x in (("front", rear + WHEELBASE), ("rear", rear)):
        for side, y in (("left", HALF_TRACK), ("right", -HALF_TRACK)):
            name = f"{axle}_{side}"
            steers = kind is DriveKind.ACKERMANN and axle == "front"
            roller = math.copysign(MECANUM, -x * y) if kind is DriveKind.OMNIDIRECTIONAL else 0.0
            steering = f"{name}_steering" if steers else None
            wheels.append(
                WheelDeclaration(joint=f"{name}_wheel", x=x, y=y, radius=RADIUS, roller=roller, steering=steering)
            )
            links.append(_wheel(name))
            if steering is not None:
                links.append(f'<link name="{name}_hinge">{_inertial(0.1, 1e-3)}</link>')
                joints.append(_joint(steering, "revolute", "base", f"{name}_hinge", (x, y, RADIUS), "0 0 1"))
            parent, place = (f"{name}_hinge", (0.0, 0.0, 0.0)) if steers else ("base", (x, y, RADIUS))
            joints.append(_joint(f"{name}_wheel", "continuous", parent, name, place, "0 1 0"))
    body = (
        f'<link name="base"><inertial><origin xyz="{rear + WHEELBASE / 2} 0 0.15"/><mass value="20"/>'
        '<inertia ixx="0.6" iyy="0.9" izz="1.3" ixy="0" ixz="0" iyz="0"/></inertial>'
        f'<collision><origin xyz="{rear + WHEELBASE / 2} 0 0.2"/><geometry><box size="0.7 0.4 0.15"/></geometry>'
        "</collision></link>"
    )
    urdf = f'<robot name="{kind.value}">{body}{"".join(links)}{"".join(joints)}</robot>'
    mobile = MobileDeclaration(radius=0.9, clearance=0.9, drive=_drive(kind, tuple(wheels)), odometry=EXACT)
    return RobotDeclaration(
        model=kind.value,
        source=urdf,
        urdf=urdf,
        kinds=("differential_drive_robot",),
        base_link="base",
        body_friction=0.3,
        mobile=mobile,
    )


def _drive(kind: DriveKind, wheels: tuple[WheelDeclaration, ...]) -> PlanarDrive:
    assert kind is not DriveKind.DIFFERENTIAL
    return PlanarDrive(
        kind=kind,
        wheels=wheels,
        max_speed=1.0,
        max_acceleration=2.0,
        max_turn_rate=1.5,
        max_turn_acceleration=4.0,
        motor_gain=10.0,
        motor_torque=20.0,
        armature=0.02,
        wheel_friction=1.0,
        max_lateral_speed=1.0 if kind is DriveKind.OMNIDIRECTIONAL else 0.0,
        min_turning_radius=TURNING_RADIUS if kind is DriveKind.ACKERMANN else 0.0,
    )


def _inertial(mass: float, moment: float) -> str:
    return (
        f'<inertial><mass value="{mass}"/><inertia ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" '
        'iyz="0"/></inertial>'
    )


def _wheel(name: str) -> str:
    return (
        f'<link name="{name}">{_inertial(1.0, 5e-3)}<collision><origin rpy="1.5707963 0 0"/><geometry>'
        f'<cylinder radius="{RADIUS}" length="0.06"/></geometry></collision></link>'
    )


def _joint(name: str, kind: str, parent: str, child: str, place: tuple[float, float, float], axis: str) -> str:
    limit = '<limit lower="-1" upper="1" effort="100" velocity="100"/>' if kind == "revolute" else ""
    x, y, z = place
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{x} {y} {z}"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="{axis}"/>{limit}</joint>'
    )


def built_drive(make: Make, kind: DriveKind, pose: Pose2 = ORIGIN) -> Engine:
    """Return a new engine with a robot of a kind of drive."""
    engine = make()
    engine.build(Scene((), (PlacedRobot(ROBOT, robot_with(kind), pose),), EXTENT))
    return engine


def drive_of(kind: DriveKind) -> PlanarDrive:
    """Return the drive of `robot_with`."""
    mobile = robot_with(kind).mobile
    assert mobile is not None and isinstance(mobile.drive, PlanarDrive)
    return mobile.drive


def command(engine: Engine, kind: DriveKind, velocity: Velocity, seconds: float) -> None:
    """Command a velocity of the base, and simulate for a duration [s]."""
    engine.command_wheels(ROBOT, *motor_commands(drive_of(kind), velocity))
    run(engine, seconds)


PLANAR = (DriveKind.SKID_STEER, DriveKind.OMNIDIRECTIONAL, DriveKind.ACKERMANN)


def planar_drives_go_straight(make: Make) -> None:
    """A robot of any planar drive at 0.3 m/s drives 3 m in 10 s within 2 %, straight; its wheels turn as far."""
    for kind in PLANAR:
        engine = built_drive(make, kind, Pose2(-1.0, 1.0, math.pi / 2))
        command(engine, kind, Velocity(0.3, 0.0), 10.0)
        found = engine.body_state(ROBOT)
        expect_near(f"the distance of the drive {kind.value} in 10 s [m]", found.position[1] - 1.0, 3.0, 0.06)
        expect_near("the distance off the line [m]", found.position[0], -1.0, 0.01)
        expect_near("the heading [rad]", found.planar.yaw, math.pi / 2, 0.01)
        expect_near("the height of the base [m]", found.position[2], 0.0, 2e-3)
        rolled = base_motion(drive_of(kind), engine.wheel_angles(ROBOT)).linear
        expect_near("the distance that its wheels have rolled [m]", rolled, 3.0, 0.06)


def planar_drives_turn_in_place(make: Make) -> None:
    """Robots that do not steer turn in place: by 3 rad in 3 s at 1 rad/s, within 5 %."""
    for kind in (DriveKind.SKID_STEER, DriveKind.OMNIDIRECTIONAL):
        engine = built_drive(make, kind)
        command(engine, kind, Velocity(0.0, 1.0), 3.0)
        found = engine.body_state(ROBOT)
        expect_near(f"the heading of the drive {kind.value} after 3 s [rad]", found.planar.yaw, 3.0, 0.15)
        expect_near("the place after 3 s", found.position, (0.0, 0.0, 0.0), 0.02)


def omnidirectional_drives_move_sideways(make: Make) -> None:
    """An omnidirectional drive moves 1.5 m to the left in 5 s at 0.3 m/s within 2 %, and keeps its heading."""
    engine = built_drive(make, DriveKind.OMNIDIRECTIONAL)
    command(engine, DriveKind.OMNIDIRECTIONAL, Velocity(0.0, 0.0, 0.3), 5.0)
    found = engine.body_state(ROBOT)
    expect_near("the place after 5 s", found.position, (0.0, 1.5, 0.0), 0.03)
    expect_near("the heading [rad]", found.planar.yaw, 0.0, 0.01)


def ackermann_drives_circle(make: Make) -> None:
    """An Ackermann drive returns after a circle of 1 m radius, within 4 % of its way, and cannot turn in place."""
    engine, kind = built_drive(make, DriveKind.ACKERMANN), DriveKind.ACKERMANN
    command(engine, kind, Velocity(0.5, 0.5), 4.0 * math.pi)
    found = engine.body_state(ROBOT)
    expect_near("the place after a circle", found.position[:2], (0.0, 0.0), 0.25)
    command(engine, kind, Velocity(0.0, 1.0), 1.0)
    before = engine.body_state(ROBOT).planar
    run(engine, 1.0)
    after = engine.body_state(ROBOT).planar
    expect_near("the turn in place [rad]", after.yaw - before.yaw, 0.0, 0.01)


def planar_drives_stop_without_power(make: Make) -> None:
    """A planar drive without power coasts to rest; with power, it obeys the last command."""
    kind = DriveKind.OMNIDIRECTIONAL
    engine = built_drive(make, kind)
    command(engine, kind, Velocity(0.3, 0.0), 1.0)
    engine.power_wheels(ROBOT, False)
    run(engine, 6.0)
    speed = math.hypot(*engine.body_state(ROBOT).linear)
    expect(speed < 0.01, f"a robot without power still moves at {speed:.3f} m/s after 6 s")
    engine.power_wheels(ROBOT, True)
    run(engine, 1.0)
    expect_near("the velocity with power again", engine.body_state(ROBOT).linear[0], 0.3, 0.015)
