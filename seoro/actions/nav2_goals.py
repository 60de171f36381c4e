"""Actions of `osc.nav2` that drive to poses.

A simulator navigates itself; behind a bridge, the robot's own navigation does. Parameters for topics and frames of
Nav2 must have their defaults there: the bridge knows the names of its robot. Other robots are in the ROS 2 system
of the run, with the names of these parameters.
"""

from __future__ import annotations

from collections.abc import Coroutine, Sequence
from typing import Any

from seoro.actions.goals import pursue
from seoro.actions.localization import wait_for_localization
from seoro.actions.nav2_localization import LOCALISED, set_initial_pose, wait_until_active, wait_until_localized
from seoro.actions.nav2_requests import BASE, run_goal, stamped, stamped_poses
from seoro.actions.ros_only import refuse_unless
from seoro.actions.ros_robots import full_name
from seoro.actions.ros_support import system_of
from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.robots import MobileRobots
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("differential_drive_robot.init_nav2", home=MobileRobots | Ros2System)
async def init_nav2(
    ctx: ActionContext,
    robot: Actor,
    initial_pose: Pose3D,
    base_frame_id: str,
    use_initial_pose: bool,
    namespace_override: str,
    wait_for_initial_pose: bool,
    wait_for_amcl: bool,
) -> None:
    """Prepare navigation and set the robot's initial pose."""
    if not ctx.is_home(robot, MobileRobots):
        await _init_in_ros(
            ctx,
            robot,
            initial_pose if use_initial_pose else None,
            namespace_override,
            wait_for_initial_pose=wait_for_initial_pose,
            wait_for_amcl=wait_for_amcl,
        )
        return
    # `wait_for_amcl` always holds: setting a pose waits until the localization has accepted it, and goals wait for
    # the navigation.
    refuse_unless(base_frame_id=(base_frame_id, "base_link"), namespace_override=(namespace_override, ""))
    if use_initial_pose:
        robots, name = ctx.home(robot, MobileRobots)
        await ctx.ask(robots.set_initial_pose(name, initial_pose))
    if wait_for_initial_pose:
        await wait_for_localization(ctx, robot)


async def _init_in_ros(
    ctx: ActionContext,
    robot: Actor,
    pose: Pose3D | None,
    namespace: str,
    *,
    wait_for_initial_pose: bool,
    wait_for_amcl: bool,
) -> None:
    # The frame of the base is not needed: localizations publish its pose.
    if wait_for_amcl:
        await wait_until_active(ctx, full_name(robot, namespace, "amcl"))
    if pose is not None:
        await set_initial_pose(ctx, robot, pose, namespace)
    elif wait_for_initial_pose:
        await wait_until_localized(ctx, system_of(ctx), full_name(robot, namespace, LOCALISED))
    await wait_until_active(ctx, full_name(robot, namespace, "bt_navigator"))


@action("differential_drive_robot.nav_to_pose", home=MobileRobots | Ros2System, uses=BASE)
async def nav_to_pose(
    ctx: ActionContext,
    robot: Actor,
    goal_pose: Pose3D,
    namespace_override: str,
    action_topic: str,
    success_on_acceptance: bool,
) -> None:
    """Drive to a pose."""
    if not ctx.is_home(robot, MobileRobots):
        goal = {"pose": stamped(goal_pose)}
        name = full_name(robot, namespace_override, action_topic)
        await run_goal(ctx, name, "NavigateToPose", goal, success_on_acceptance=success_on_acceptance)
        return
    refuse_unless(namespace_override=(namespace_override, ""), action_topic=(action_topic, "navigate_to_pose"))
    await drive_through(ctx, robot, (goal_pose,), stop_at_each=False, success_on_acceptance=success_on_acceptance)


@action("differential_drive_robot.nav_through_poses", home=MobileRobots | Ros2System, uses=BASE)
async def nav_through_poses(
    ctx: ActionContext,
    robot: Actor,
    goal_poses: Sequence[Pose3D],
    namespace_override: str,
    action_topic: str,
    success_on_acceptance: bool,
) -> None:
    """Drive through poses without stopping at each."""
    if not ctx.is_home(robot, MobileRobots):
        goal = {"poses": stamped_poses(goal_poses)}
        name = full_name(robot, namespace_override, action_topic)
        await run_goal(ctx, name, "NavigateThroughPoses", goal, success_on_acceptance=success_on_acceptance)
        return
    refuse_unless(
        namespace_override=(namespace_override, ""), action_topic=(action_topic, "navigate_through_poses")
    )
    await drive_through(ctx, robot, goal_poses, stop_at_each=False, success_on_acceptance=success_on_acceptance)


@action("differential_drive_robot.follow_waypoints", home=MobileRobots | Ros2System, uses=BASE)
async def follow_waypoints(
    ctx: ActionContext,
    robot: Actor,
    goal_poses: Sequence[Pose3D],
    loop_count: int,
    namespace_override: str,
    action_topic: str,
    success_on_acceptance: bool,
) -> None:
    """Drive to each pose in order, and repeat all of them `loop_count` times."""
    if loop_count < 0:
        raise ActionFailed(f"invalid `loop_count`: expected at least 0, found {loop_count}")
    if not ctx.is_home(robot, MobileRobots):
        goal = {"poses": stamped_poses(list(goal_poses) * (loop_count + 1))}
        name = full_name(robot, namespace_override, action_topic)
        await run_goal(ctx, name, "FollowWaypoints", goal, success_on_acceptance=success_on_acceptance)
        return
    refuse_unless(namespace_override=(namespace_override, ""), action_topic=(action_topic, "follow_waypoints"))
    poses = list(goal_poses) * (loop_count + 1)
    await drive_through(ctx, robot, poses, stop_at_each=True, success_on_acceptance=success_on_acceptance)


async def drive_through(
    ctx: ActionContext,
    robot: Actor,
    poses: Sequence[Pose3D],
    *,
    stop_at_each: bool,
    success_on_acceptance: bool = False,
) -> None:
    """Drive a robot through poses.

    Args:
        ctx: Context of the action.
        robot: The robot.
        poses: Poses in order, at least one.
        stop_at_each: Whether to stop at each pose, not only at the last.
        success_on_acceptance: Whether the action ends as soon as the goal is accepted.

    Raises:
        ActionFailed: `poses` is empty, or the robot does not arrive.
    """
    if not poses:
        raise ActionFailed("no goal pose given; expected at least one")
    robots, name = ctx.home(robot, MobileRobots)

    def start(report: Reporter) -> Coroutine[Any, Any, str]:
        return robots.navigate(name, poses, stop_at_each=stop_at_each, report=report)

    await pursue(ctx, robot, BASE, start, robots.cancel_goal, success_on_acceptance=success_on_acceptance)
