"""Actions of `osc.moveit2`: motions of arms.

The backend of the arm plans and moves: a simulator, or MoveIt on the robot. Poses are those of the tool in the
frame of the arm's base, named by the field `base_link` of the actor. A bridge knows the robot's topics and groups;
in the ROS 2 system of a run, fields of the actor name them.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial

from seoro.actions.goals import pursue
from seoro.actions.moveit_requests import move_group as move_group_in_ros
from seoro.actions.moveit_scene import (  # noqa: F401 - further actions of the library
    add_collision_object,
    attach_object,
    check_collision_object,
    detach_object,
    move_along_poses,
    move_to_named_pose,
    remove_collision_object,
)
from seoro.actions.ros_only import refuse_unless
from seoro.actions.ros_robots import full_name, pose_message
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.robotics.geometry import Pose3D
from seoro.robotics.moveit_goals import joint_constraints, pose_constraints
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.robots import Arms, MotionOptions
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor, Value

ARM = "arm"  # one motion at a time
GRIPPER = "gripper"  # one motion at a time, independent of the arm
BASE_FRAME = "base_link"


def _moved(fields: Mapping[str, Value]) -> str:
    """Return the part of the robot named by `move_group`."""
    group = fields["move_group"]
    assert isinstance(group, EnumValue), "declared as an enumeration"
    return group.member


@action("arm.move_to_joint_pose", home=Arms | Ros2System, uses=_moved)
async def move_to_joint_pose(
    ctx: ActionContext,
    arm: Actor,
    goal_pose: Sequence[float],
    move_group: EnumValue,
    plan_only: bool,
    replan: bool,
    tolerance: float,
    max_velocity_scaling_factor: float,
    namespace_override: str,
    action_topic: str,
    success_on_acceptance: bool,
) -> None:
    """Move the joints of the arm, or the fingers of its gripper, to positions."""
    if not ctx.is_home(arm, Arms):
        group = str(arm.fields[f"{move_group.member}_group"])
        names = _strings(arm, f"{move_group.member}_joints")
        if len(names) != len(goal_pose):
            raise ActionFailed(
                f"expected a position for each of `{move_group.member}_joints` of `{arm.name}`: "
                f"{', '.join(names) or 'none'}; found {len(goal_pose)} positions"
            )
        constraints = joint_constraints(dict(zip(names, goal_pose, strict=True)), tolerance)
        options = MotionOptions(max_velocity_scaling_factor, tolerance, (), plan_only, replan)
        name = full_name(arm, namespace_override, action_topic)
        await move_group_in_ros(
            ctx, name, group, constraints, options, success_on_acceptance=success_on_acceptance
        )
        return
    refuse_unless(namespace_override=(namespace_override, ""), action_topic=(action_topic, "move_action"))
    arms, name = ctx.home(arm, Arms)
    options = MotionOptions(max_velocity_scaling_factor, tolerance, (), plan_only, replan)
    start: Callable[[Reporter], Awaitable[str]]
    part = move_group.member
    if part == GRIPPER:
        if plan_only:
            raise ActionFailed("`plan_only` applies to the arm only; omit it for the gripper")
        start = partial(arms.move_gripper, name, _opening(goal_pose), None, options)
    else:
        start = partial(arms.move_joints, name, goal_pose, _strings(arm, "arm_joints"), options)
    await pursue(ctx, arm, part, start, arms.cancel_goal, success_on_acceptance=success_on_acceptance)


@action("arm.move_to_pose", home=Arms | Ros2System, uses=ARM)
async def move_to_pose(
    ctx: ActionContext,
    arm: Actor,
    goal_pose: Pose3D,
    plan_only: bool,
    replan: bool,
    tolerance: float,
    max_velocity_scaling_factor: float,
    namespace_override: str,
    action_topic: str,
    success_on_acceptance: bool,
) -> None:
    """Move the tool to a pose in the frame of the arm's base."""
    frame = str(arm.fields.get("base_link") or BASE_FRAME)
    options = MotionOptions(max_velocity_scaling_factor, tolerance, (), plan_only, replan)
    if not ctx.is_home(arm, Arms):
        link, group = str(arm.fields["end_effector"]), str(arm.fields["arm_group"])
        constraints = pose_constraints(link, frame, pose_message(goal_pose), tolerance)
        name = full_name(arm, namespace_override, action_topic)
        await move_group_in_ros(
            ctx, name, group, constraints, options, success_on_acceptance=success_on_acceptance
        )
        return
    refuse_unless(namespace_override=(namespace_override, ""), action_topic=(action_topic, "move_action"))
    arms, name = ctx.home(arm, Arms)
    start = partial(arms.move_tool, name, goal_pose, frame, options, straight=False)
    await pursue(ctx, arm, ARM, start, arms.cancel_goal, success_on_acceptance=success_on_acceptance)


def _opening(goal_pose: Sequence[float]) -> float:
    """Return the opening of a gripper for finger positions [m], given once or for each finger."""
    if len(goal_pose) not in (1, 2) or goal_pose[0] != goal_pose[-1]:
        raise ActionFailed(
            f"expected one position for both fingers, or two equal positions, found {list(goal_pose)}"
        )
    return 2.0 * goal_pose[0]


def _strings(actor: Actor, field: str) -> tuple[str, ...]:
    """Return a list of strings from a field of an actor; empty if missing."""
    found = actor.fields.get(field)
    return tuple(map(str, found)) if isinstance(found, list | tuple) else ()
