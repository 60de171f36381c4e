"""The robots of a world file: their declarations, and where they stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from seoro.files.yaml_lines import FileError
from sim_nodes.geometry import Pose2
from sim_nodes.physics import PlacedRobot
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.reading import available_robots, load_robot, read_robot
from sim_nodes.robots.sensor_declarations import GpsDeclaration
from sim_nodes.terrain.ground import Ground
from sim_nodes.terrain.placing import radius_of, stance, steepness
from sim_nodes.worlds.schema import RobotFile, WorldFile
from sim_nodes.worlds.sources import START

STEEPEST = 0.6  # [rad] slope on which robots start


def placed_robots(
    file: WorldFile, folder: Path, starts: Mapping[str, Pose2], ground: Ground
) -> tuple[PlacedRobot, ...]:
    """Return the robots of a world at their places.

    Args:
        file: The world file.
        folder: Folder of the world file, for paths of declarations.
        starts: Named poses.
        ground: The ground.

    Raises:
        FileError: A robot is invalid, unknown, or at an invalid place.
    """
    placed = []
    for index, robot in enumerate(file.robots):
        declaration = _declaration(robot.robot, f"robots.{index}.robot", folder)
        pose = _start(robot, index, starts)
        if robot.pose.z and not declaration.fixed:
            raise FileError(f"robots.{index}.pose.z: unexpected z: a {robot.robot} stands on the floor; remove it")
        if robot.battery is not None:
            if declaration.mobile is None:
                raise FileError(
                    f"robots.{index}.battery: unexpected battery: a {robot.robot} does not drive; remove it"
                )
            mobile = declaration.mobile.model_copy(update={"battery": robot.battery})
            declaration = declaration.model_copy(update={"mobile": mobile})
        for sensor in declaration.sensors:
            if isinstance(sensor, GpsDeclaration) and file.geo_origin is None:
                raise FileError(
                    f"robots.{index}: {robot.name!r} has a GPS, {sensor.name!r}; expected `geo_origin` of "
                    "the world (`latitude`, `longitude`, `altitude`)"
                )
        placed.append(_standing(PlacedRobot(robot.name, declaration, pose, robot.pose.z), index, ground))
    return tuple(placed)


def _standing(robot: PlacedRobot, index: int, ground: Ground) -> PlacedRobot:
    """Return a robot on the ground; a fixed one has its own height, if it has one."""
    if ground.is_flat or (robot.declaration.fixed and robot.height):
        return robot
    x, y, _ = robot.pose
    if robot.declaration.fixed:
        return replace(robot, height=ground.height(x, y))
    height, tilt = stance(ground, x, y, radius_of(robot.declaration))
    if steepness(tilt) > STEEPEST:
        raise FileError(
            f"robots.{index}.pose: {robot.name!r} at x {x:g} m, y {y:g} m would stand on a slope of "
            f"{steepness(tilt):.2f} rad; expected at most {STEEPEST} rad"
        )
    return replace(robot, height=height, tilt=tilt)


def _start(robot: RobotFile, index: int, starts: Mapping[str, Pose2]) -> Pose2:
    pose = Pose2(robot.pose.x, robot.pose.y, robot.pose.yaw)
    if robot.pose.at is None:
        return pose
    if robot.pose.at not in starts:
        known = ", ".join([*starts, *({START} - starts.keys())])
        raise FileError(f"robots.{index}.pose.at: unknown pose {robot.pose.at!r} (poses: {known})")
    return starts[robot.pose.at].compose(pose)


def _declaration(robot: str, place: str, folder: Path) -> RobotDeclaration:
    if robot.endswith(".yaml"):
        return _own_robot(folder / robot, place)
    if robot not in available_robots():
        known = ", ".join(available_robots())
        raise FileError(
            f"{place}: unknown kind of robot {robot!r} (kinds: {known}, or the path of a declaration, .yaml)"
        )
    try:
        return load_robot(robot)
    except FileError as error:
        raise FileError(f"{place}: {error}") from error


def _own_robot(path: Path, place: str) -> RobotDeclaration:
    try:
        return read_robot(path)
    except FileError as error:
        raise FileError(f"{place}: {error}") from error
