"""Paths that robots of world files follow from the start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.deferred import dataclass
from seoro.files.yaml_lines import FileError
from sim_nodes.agents.walls import Walls
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.physics import PlacedRobot
from sim_nodes.worlds.schema import RobotFile


@dataclass(frozen=True)
class RobotPath:
    """A path that a robot follows by its true pose, until a scenario commands it.

    Attributes:
        points: Its points; the first one is the start of the robot [m].
        speed: [m/s]
        repeat: Whether the second point follows the last one.
    """

    points: tuple[tuple[float, float], ...]
    speed: float
    repeat: bool


def read_paths(
    files: Sequence[RobotFile], robots: Sequence[PlacedRobot], known: NavigationMap
) -> Mapping[str, RobotPath]:
    """Return the paths by robot.

    Args:
        files: Entries of a world file.
        robots: The robots of these entries.
        known: Map of the world.

    Raises:
        FileError: A robot cannot follow its path.
    """
    walls = Walls(known)
    return {
        robot.name: _path(file, f"robots.{index}", robot, walls)
        for index, (file, robot) in enumerate(zip(files, robots, strict=True))
        if file.path is not None
    }


def _path(file: RobotFile, place: str, robot: PlacedRobot, walls: Walls) -> RobotPath:
    assert file.path is not None
    mobile = robot.declaration.mobile
    if mobile is None:
        raise FileError(f"{place}.path: unexpected path: a {file.robot} does not drive; remove it")
    speed = mobile.drive.max_speed if file.speed is None else file.speed
    if speed > mobile.drive.max_speed:
        raise FileError(
            f"{place}.speed: invalid speed {speed:g} m/s of {file.name!r}; "
            f"expected at most {mobile.drive.max_speed:g} m/s"
        )
    points = ((robot.pose.x, robot.pose.y), *file.path.points)
    closing = file.path.points[:1] if file.path.repeat else ()
    if problem := walls.describe_block((*points, *closing), mobile.radius):
        raise FileError(f"{place}.path: {problem}")
    return RobotPath(points, speed, file.path.repeat)
