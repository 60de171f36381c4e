"""Actions of `osc.moveit2`: motions of arms.

The backend of the arm plans and moves: a simulator, or MoveIt on the robot. Poses are those of the tool in the
frame of the arm's base, named by the field `base_link` of the actor. The bridge knows the robot's topics and
groups.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial

from seoro.actions.goals import pursue
from seoro.actions.ros_only import refuse_unless
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.robots import Arms, MotionOptions
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


@action("arm.move_to_joint_pose", home=Arms, uses=_moved)
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


@action("arm.move_to_pose", home=Arms, uses=ARM)
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
    refuse_unless(namespace_override=(namespace_override, ""), action_topic=(action_topic, "move_action"))
    arms, name = ctx.home(arm, Arms)
    options = MotionOptions(max_velocity_scaling_factor, tolerance, (), plan_only, replan)
    frame = str(arm.fields.get("base_link") or BASE_FRAME)
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
