"""The verb that describes robots."""

from __future__ import annotations

from seoro.bridges import wire
from sim_nodes.robots.declaration import ArmDeclaration, MobileDeclaration
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _get_robot_description(simulator: Simulator, request: wire.RobotName) -> wire.RobotDescription:
    robot = simulator.simulation.robot(request.robot)
    declaration = robot.declaration
    mobile, arm = declaration.mobile, declaration.arm
    return wire.RobotDescription(
        urdf=declaration.urdf,
        base_link=declaration.base_link,
        sensors=tuple(robot.sensors),
        lidar=None if mobile is None else _lidar(mobile),
        arm=None if arm is None else _arm(arm),
        max_speed=0.0 if mobile is None else mobile.drive.max_speed,
        max_turn_rate=0.0 if mobile is None else mobile.drive.max_turn_rate,
        has_battery=mobile is not None and mobile.battery is not None,
    )


def _lidar(mobile: MobileDeclaration) -> wire.LidarDescription:
    lidar = mobile.lidar
    return wire.LidarDescription(
        link=lidar.link, yaw=lidar.yaw, range_min=lidar.min_range, range_max=lidar.max_range, rate=lidar.rate
    )


def _arm(arm: ArmDeclaration) -> wire.ArmDescription:
    return wire.ArmDescription(
        joints=tuple(joint.name for joint in arm.joints), fingers=arm.gripper.joints, stroke=arm.gripper.stroke
    )


HANDLERS: tuple[Handling, ...] = ((wire.GET_ROBOT_DESCRIPTION, _get_robot_description),)
