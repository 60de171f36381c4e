"""Actions of `osc.nav2` at docks, by the docking server."""

from __future__ import annotations

from seoro.actions.nav2_requests import BASE, run_goal, stamped
from seoro.actions.ros_robots import full_name
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("differential_drive_robot.dock", anywhere=Ros2System, uses=BASE)
async def dock(
    ctx: ActionContext,
    robot: Actor,
    dock_id: str,
    navigate_to_staging_pose: bool,
    max_staging_time: float,
    namespace_override: str,
) -> None:
    """Drive to a dock of the docking server, and dock."""
    goal = {"use_dock_id": True, "dock_id": dock_id}
    await _dock(ctx, robot, goal, max_staging_time, namespace_override, stages=navigate_to_staging_pose)


@action("differential_drive_robot.dock_at_pose", anywhere=Ros2System, uses=BASE)
async def dock_at_pose(
    ctx: ActionContext,
    robot: Actor,
    dock_pose: Pose3D,
    dock_type: str,
    navigate_to_staging_pose: bool,
    max_staging_time: float,
    namespace_override: str,
) -> None:
    """Drive to a dock at a pose, and dock."""
    goal = {"use_dock_id": False, "dock_pose": stamped(dock_pose), "dock_type": dock_type}
    await _dock(ctx, robot, goal, max_staging_time, namespace_override, stages=navigate_to_staging_pose)


async def _dock(
    ctx: ActionContext,
    robot: Actor,
    goal: dict[str, object],
    max_staging_time: float,
    namespace: str,
    *,
    stages: bool,
) -> None:
    goal |= {"navigate_to_staging_pose": stages, "max_staging_time": max_staging_time}
    await run_goal(ctx, full_name(robot, namespace, "dock_robot"), "DockRobot", goal)


@action("differential_drive_robot.undock", anywhere=Ros2System, uses=BASE)
async def undock(
    ctx: ActionContext, robot: Actor, dock_type: str, max_undocking_time: float, namespace_override: str
) -> None:
    """Leave the dock."""
    goal = {"dock_type": dock_type, "max_undocking_time": max_undocking_time}
    await run_goal(ctx, full_name(robot, namespace_override, "undock_robot"), "UndockRobot", goal)
