"""Requests of `osc.nav2` to Nav2 in the ROS 2 system of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.actions.ros_requests import call, run_to_success, store_member
from seoro.actions.ros_robots import pose_message
from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Members
from seoro.runtime.values.values import Variable

BASE = "base"  # part of a robot with one destination at a time
MAP = "map"  # frame of goals

_NANO = 1_000_000_000


def duration(seconds: float) -> Members:
    """Return a `builtin_interfaces/Duration`.

    Raises:
        ActionFailed: The duration is negative.
    """
    if seconds < 0.0:
        raise ActionFailed(f"invalid duration: expected at least 0 s, found {seconds:g} s")
    whole, part = divmod(round(seconds * _NANO), _NANO)
    return {"sec": whole, "nanosec": part}


def stamped(pose: Pose3D, frame: str = MAP) -> dict[str, Any]:
    """Return a `geometry_msgs/PoseStamped`; its stamp of zero selects the latest transform."""
    return {"header": {"frame_id": frame}, "pose": pose_message(pose)}


def stamped_poses(poses: Sequence[Pose3D]) -> list[dict[str, Any]]:
    """Return `geometry_msgs/PoseStamped` of poses in the map.

    Raises:
        ActionFailed: `poses` is empty.
    """
    if not poses:
        raise ActionFailed("no pose given; expected at least one")
    return [stamped(pose) for pose in poses]


async def run_goal(
    ctx: ActionContext, name: str, kind: str, goal: Mapping[str, Any], *, success_on_acceptance: bool = False
) -> Members:
    """Send a goal to an action of Nav2, and return the result; empty with `success_on_acceptance`.

    Args:
        ctx: Context of the action.
        name: Full name of the ROS action.
        kind: Name of its type in `nav2_msgs`.
        goal: Members of the goal.
        success_on_acceptance: Whether to return once the goal is accepted.

    Raises:
        ActionFailed: The goal failed, also if Nav2 reports that by the result only.
    """
    type_name = f"nav2_msgs/action/{kind}"
    return await run_to_success(ctx, name, type_name, goal, success_on_acceptance=success_on_acceptance) or {}


async def call_service(ctx: ActionContext, name: str, kind: str, request: Mapping[str, Any]) -> Members:
    """Call a service of Nav2, and return the response.

    Args:
        ctx: Context of the action.
        name: Full name of the service.
        kind: Type of the service, in `nav2_msgs` if it has no package.
        request: Members of the request.

    Raises:
        ActionFailed: The call failed, or the response has `success: false`.
    """
    response = await call(ctx, name, kind if "/" in kind else f"nav2_msgs/srv/{kind}", request)
    if response.get("success") is False:
        text = str(response.get("message", ""))
        raise ActionFailed(f"{name} reports no success{f': {text}' if text else '; look at the log of its node'}")
    return response


def store_path(ctx: ActionContext, target: Variable[object] | str, result: Members) -> None:
    """Store the path of a result in a variable of the type `string`, if one is given."""
    if isinstance(target, Variable):
        store_member(ctx, target, result, "path", "the result")
