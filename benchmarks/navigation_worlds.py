"""Worlds of `navigation_quality.py`: other drives and outlines, and generated fields of obstacles."""

from __future__ import annotations

from dataclasses import replace

from sim_nodes.check.drives import robot_with
from sim_nodes.robots.declaration import LidarDeclaration, RobotDeclaration
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.footprint import Footprint
from sim_nodes.worlds.loader import World, load_world, parse_world

ROBOT = "turtlebot4"  # name of the robot in all worlds
ROOM = """name: room
extent: [-3.05, -3.05, 4.05, 3.05]
walls:
  - points: [[-3, -3], [4, -3], [4, 3], [-3, 3], [-3, -3]]
  - points: [[1, -3], [1, -0.5]]
  - points: [[1, 0.5], [1, 3]]
  - points: [[-3, 1.6], [-1.6, 1.6]]
robots: [{name: turtlebot4, robot: %s, pose: {x: -1.0, y: 0.0}}]
"""
PLATFORM = Footprint(((0.36, 0.31), (-0.36, 0.31), (-0.36, -0.31), (0.36, -0.31)))
MAST = (
    '<link name="laser"/><joint name="mast" type="fixed"><origin xyz="0 0 0.2"/><parent link="base"/>'
    '<child link="laser"/></joint></robot>'
)
LIDAR = LidarDeclaration(
    link="laser", x=0.0, y=0.0, yaw=0.0, beams=360, rate=10.0, min_range=0.1, max_range=10.0, noise=0.01
)


def room_with(robot: str) -> World:
    """Return a room of 7 by 6 m with a door of 0.9 m and a robot by its name."""
    return parse_world(ROOM % robot, "room.yaml")


def room_with_platform() -> World:
    """Return the room with an omnidirectional platform of 0.72 by 0.62 m."""
    room = room_with("turtlebot4")
    return replace(room, robots=(replace(room.robots[0], declaration=platform()),))


def platform() -> RobotDeclaration:
    """Return an omnidirectional robot with a lidar."""
    declared = robot_with(DriveKind.OMNIDIRECTIONAL)
    assert declared.mobile is not None
    radius = PLATFORM.radius
    update = {"footprint": PLATFORM, "radius": radius, "clearance": radius + 0.02, "lidar": LIDAR}
    mobile = declared.mobile.model_copy(update=update)
    urdf = declared.urdf.replace("</robot>", MAST)
    return declared.model_copy(update={"mobile": mobile, "urdf": urdf, "source": urdf})


def obstacle_field(seed: int) -> World:
    """Return a field of obstacles in the manner of BARN, another one for each seed."""
    return load_world("obstacle_field", seed)
