"""Actions of `osc.moveit2`: motions of arms.

Who serves the arm plans and moves: a simulator, or MoveIt on the robot. Poses are those of the tool in the frame
of the arm's base, as the actor's `base_link` calls it. Names of topics and groups are those of the robot, which
its bridge knows.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial

from seoro.actions.goals import pursue
from seoro.actions.ros_only import refuse_unless
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Arms, Manner
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Pose3D, Reporter
from seoro.runtime.values import Actor, Value

ARM = "arm"  # makes one motion at a time
GRIPPER = "gripper"  # does one thing at a time, also while the arm moves
BASE_FRAME = "base_link"


def _moved(fields: Mapping[str, Value]) -> str:
    """The part that `move_group` names."""
    group = fields["move_group"]
    assert isinstance(group, EnumValue), "as it is declared"
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
    manner = Manner(max_velocity_scaling_factor, tolerance, (), plan_only, replan)
    start: Callable[[Reporter], Awaitable[str]]
    part = move_group.member
    if part == GRIPPER:
        _refuse_planning(plan_only)
        start = partial(arms.move_gripper, name, _opening(goal_pose), None, manner)
    else:
        start = partial(arms.move_joints, name, goal_pose, _strings(arm, "arm_joints"), manner)
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
    manner = Manner(max_velocity_scaling_factor, tolerance, (), plan_only, replan)
    frame = str(arm.fields.get("base_link") or BASE_FRAME)

    def start(report: Reporter) -> Awaitable[str]:
        return arms.move_tool(name, goal_pose, frame, manner, report, straight=False)

    await pursue(ctx, arm, ARM, start, arms.cancel_goal, success_on_acceptance=success_on_acceptance)


def _refuse_planning(plan_only: bool) -> None:
    if plan_only:
        raise ActionFailed("`plan_only` has a meaning for the arm only; leave it out for the gripper")


def _opening(goal_pose: Sequence[float]) -> float:
    """The opening of a gripper by the positions of its fingers [m], or the one that both have."""
    if len(goal_pose) not in (1, 2) or goal_pose[0] != goal_pose[-1]:
        raise ActionFailed(
            f"a gripper takes one position for both fingers, or the same for each, not {list(goal_pose)}"
        )
    return 2.0 * goal_pose[0]


def _strings(actor: Actor, field: str) -> tuple[str, ...]:
    """A list of texts in a field of an actor; empty where it has none."""
    found = actor.fields.get(field)
    return tuple(map(str, found)) if isinstance(found, list | tuple) else ()
