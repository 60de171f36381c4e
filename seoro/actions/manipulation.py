"""Actions of `osc.manipulation`: pick and place with an arm and its gripper."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from seoro.actions.goals import pursue
from seoro.actions.moveit2 import ARM, GRIPPER
from seoro.actions.reports import finish
from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import Arms, MotionOptions, Postures
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("arm.move_tool", home=Arms, uses=ARM)
async def move_tool(
    ctx: ActionContext,
    arm: Actor,
    goal_pose: Pose3D,
    frame_id: str,
    straight: bool,
    may_touch: Sequence[str],
    tolerance: float,
    max_velocity_scaling_factor: float,
) -> None:
    """Move the tool to a pose."""
    arms, name = ctx.home(arm, Arms)
    options = MotionOptions(max_velocity_scaling_factor, tolerance, tuple(may_touch))
    start = partial(arms.move_tool, name, goal_pose, frame_id, options, straight=straight)
    await pursue(ctx, arm, ARM, start, arms.cancel_goal, may_touch=may_touch)


@action("arm.take_posture", home=Postures, uses=ARM)
async def take_posture(
    ctx: ActionContext, arm: Actor, posture: str, tolerance: float, max_velocity_scaling_factor: float
) -> None:
    """Move the joints to a posture of the robot's declaration."""
    robots, name = ctx.home(arm, Postures)
    options = MotionOptions(max_velocity_scaling_factor, tolerance)
    await pursue(ctx, arm, ARM, partial(robots.take_posture, name, posture, options), robots.cancel_goal)


@action("arm.grip", home=Arms, uses=GRIPPER)
async def grip(ctx: ActionContext, arm: Actor, entity: str, force: float) -> None:
    """Close the gripper on an entity."""
    arms, name = ctx.home(arm, Arms)
    closing = partial(arms.move_gripper, name, 0.0, force, MotionOptions())
    await pursue(ctx, arm, GRIPPER, closing, arms.cancel_goal, may_touch=[entity] if entity else None)
    held = (await ctx.ask(arms.arm_state(name))).held
    if not held:
        wanted = f"'{entity}'" if entity else "anything that can be lifted"
        raise ActionFailed(f"{name} closed its gripper but does not hold {wanted}")
    if entity and held != entity:
        raise ActionFailed(f"{name} holds '{held}' instead of '{entity}'")


@action("arm.release", home=Arms, uses=GRIPPER)
async def release(ctx: ActionContext, arm: Actor, opening: float) -> None:
    """Open the gripper."""
    arms, name = ctx.home(arm, Arms)
    start = partial(arms.move_gripper, name, opening, None, MotionOptions())
    await pursue(ctx, arm, GRIPPER, start, arms.cancel_goal)


@action("arm.hold", home=Arms)
async def hold(ctx: ActionContext, arm: Actor, entity: str, duration: float) -> None:
    """Check that the gripper holds an entity for a duration."""
    arms, name = ctx.home(arm, Arms)
    await finish(ctx, partial(arms.hold_entity, name, entity, duration), arms.cancel_goal)


@action("arm.wait_for_joint", home=Arms)
async def wait_for_joint(ctx: ActionContext, arm: Actor, joint: str, position: float, tolerance: float) -> None:
    """Wait until a joint is near a position."""
    arms, name = ctx.home(arm, Arms)
    await finish(ctx, partial(arms.watch_joint, name, joint, position, tolerance), arms.cancel_watch)
