"""Limits of the requests of a run to lab robots, checked before a request is sent."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.bridges import wire
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import BackendRefused
from seoro.lab.schema import AreaFile, LimitsFile


def limit_requests(node: SimulatorNode | RobotNode, limits: Mapping[str, tuple[LimitsFile, str]]) -> None:
    """Reject requests of a run to a node that exceed limits.

    Args:
        node: The node.
        limits: Limits of its robots, by their names at the node, with their positions in the lab file.
    """

    def vet(request: wire.Message) -> None:
        name = getattr(request, "robot", "")
        for robot in [name] if name else limits:
            if robot in limits:
                limit, place = limits[robot]
                _check(robot, request, limit, place)

    node.vet = vet


def _check(robot: str, request: wire.Message, limit: LimitsFile, place: str) -> None:
    match request:
        case wire.Drive():
            _check_speed(robot, request.linear, limit, place)
        case wire.CmdVel():
            _check_speed(robot, request.twist.linear.x, limit, place)
        case wire.NavigateThroughPoses() if limit.area is not None:
            for pose in request.poses:
                _check_place(robot, pose, limit.area, place)


def _check_speed(robot: str, speed: float, limit: LimitsFile, place: str) -> None:
    if limit.speed is not None and abs(speed) > limit.speed:
        raise BackendRefused(
            f"{speed:g} m/s exceeds the limit of the robot '{robot}' in this lab, {limit.speed:g} m/s ({place})",
            wire.Result.OPERATION_FAILED,
        )


def _check_place(robot: str, pose: wire.Pose3D, area: AreaFile, place: str) -> None:
    x, y = pose.position.x, pose.position.y
    if not area.contains(x, y):
        raise BackendRefused(
            f"x {x:g} m, y {y:g} m is outside the area of the robot '{robot}' in this lab, {area} ({place})",
            wire.Result.OPERATION_FAILED,
        )
