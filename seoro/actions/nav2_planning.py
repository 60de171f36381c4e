"""Actions of `osc.nav2` with paths and routes: planner, smoother, controller and route server of Nav2.

Paths are stored in variables of the type `string`, as JSON, and given to other actions from there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from seoro.actions.nav2_requests import BASE, call_service, duration, run_goal, stamped, stamped_poses, store_path
from seoro.actions.ros_robots import full_name
from seoro.actions.ros_support import to_members
from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Members, Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor, Variable


@action("differential_drive_robot.compute_path_to_pose", anywhere=Ros2System)
async def compute_path_to_pose(
    ctx: ActionContext,
    robot: Actor,
    goal_pose: Pose3D,
    planner_id: str,
    max_length: float,
    path_variable: Variable[object] | str,
    namespace_override: str,
) -> None:
    """Plan a path to a pose, without driving."""
    name = full_name(robot, namespace_override, "compute_path_to_pose")
    result = await run_goal(ctx, name, "ComputePathToPose", {"goal": stamped(goal_pose), "planner_id": planner_id})
    _take_path(ctx, result, max_length, path_variable)


@action("differential_drive_robot.compute_path_through_poses", anywhere=Ros2System)
async def compute_path_through_poses(
    ctx: ActionContext,
    robot: Actor,
    goal_poses: Sequence[Pose3D],
    planner_id: str,
    max_length: float,
    path_variable: Variable[object] | str,
    namespace_override: str,
) -> None:
    """Plan a path through poses, without driving."""
    name = full_name(robot, namespace_override, "compute_path_through_poses")
    goal = {"goals": stamped_poses(goal_poses), "planner_id": planner_id}
    _take_path(ctx, await run_goal(ctx, name, "ComputePathThroughPoses", goal), max_length, path_variable)


def _take_path(ctx: ActionContext, result: Members, max_length: float, target: Variable[object] | str) -> None:
    """Log and store the path of a result, and check its length [m]; a `max_length` of 0 allows any."""
    poses = result["path"]["poses"]
    if not poses:
        raise ActionFailed("the planner returned an empty path")
    points = [_point(pose) for pose in poses]
    length = sum(map(math.dist, points, points[1:]))
    ctx.log(f"path of {length:.2f} m with {len(points)} poses")
    store_path(ctx, target, result)
    if 0.0 < max_length < length:
        raise ActionFailed(f"the path has a length of {length:.2f} m; expected at most {max_length:g} m")


def _point(stamped_pose: Mapping[str, Any]) -> tuple[float, float]:
    position = stamped_pose["pose"]["position"]
    return position["x"], position["y"]


@action("differential_drive_robot.smooth_path", anywhere=Ros2System)
async def smooth_path(
    ctx: ActionContext,
    robot: Actor,
    path: str,
    smoother_id: str,
    time_limit: float,
    check_collisions: bool,
    path_variable: Variable[object] | str,
    namespace_override: str,
) -> None:
    """Smooth a path."""
    goal = {
        "path": _path(path),
        "smoother_id": smoother_id,
        "max_smoothing_duration": duration(time_limit),
        "check_for_collisions": check_collisions,
    }
    result = await run_goal(ctx, full_name(robot, namespace_override, "smooth_path"), "SmoothPath", goal)
    if not result["was_completed"]:
        raise ActionFailed(f"the smoother did not complete within {time_limit:g} s; allow more time")
    _take_path(ctx, result, 0.0, path_variable)


@action("differential_drive_robot.follow_computed_path", anywhere=Ros2System, uses=BASE)
async def follow_computed_path(
    ctx: ActionContext,
    robot: Actor,
    path: str,
    controller_id: str,
    goal_checker_id: str,
    namespace_override: str,
) -> None:
    """Drive along a path by the controller of Nav2."""
    goal = {"path": _path(path), "controller_id": controller_id, "goal_checker_id": goal_checker_id}
    await run_goal(ctx, full_name(robot, namespace_override, "follow_path"), "FollowPath", goal)


@action("differential_drive_robot.check_path", anywhere=Ros2System)
async def check_path(ctx: ActionContext, robot: Actor, path: str, namespace_override: str) -> None:
    """Fail if a path leads through obstacles of the global costmap."""
    name = full_name(robot, namespace_override, "is_path_valid")
    response = await call_service(ctx, name, "IsPathValid", {"path": _path(path)})
    if not response["is_valid"]:
        indices = list(response["invalid_pose_indices"])
        raise ActionFailed(f"the path is invalid at {len(indices)} poses, first at pose {min(indices, default=0)}")


def _path(text: str) -> Members:
    members = to_members(text, "a path")
    if not members.get("poses"):
        raise ActionFailed("the path has no poses; give the variable in which `compute_path_to_pose` stored one")
    return members


@action("differential_drive_robot.compute_route", anywhere=Ros2System)
async def compute_route(
    ctx: ActionContext,
    robot: Actor,
    goal_node: int,
    start_node: int,
    path_variable: Variable[object] | str,
    namespace_override: str,
) -> None:
    """Plan a route on the graph of the route server, without driving."""
    name = full_name(robot, namespace_override, "compute_route")
    result = await run_goal(ctx, name, "ComputeRoute", _route(start_node, goal_node))
    ctx.log(f"route through the nodes {', '.join(str(node['nodeid']) for node in result['route']['nodes'])}")
    store_path(ctx, path_variable, result)


@action("differential_drive_robot.track_route", anywhere=Ros2System)
async def track_route(
    ctx: ActionContext, robot: Actor, goal_node: int, start_node: int, namespace_override: str
) -> None:
    """Plan a route, and wait until the robot has driven it; another action drives the robot."""
    name = full_name(robot, namespace_override, "compute_and_track_route")
    await run_goal(ctx, name, "ComputeAndTrackRoute", _route(start_node, goal_node))


def _route(start: int, goal: int) -> Members:
    """Return members of a goal; a negative start is the pose of the robot."""
    members = {"goal_id": goal, "use_poses": False}
    return {**members, "start_id": start, "use_start": True} if start >= 0 else {**members, "use_start": False}
