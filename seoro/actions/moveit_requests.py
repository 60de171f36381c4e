"""Requests of `osc.moveit2` to MoveIt in the ROS 2 system of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from seoro.actions.ros_requests import call, run_to_success
from seoro.actions.ros_robots import full_name
from seoro.actions.ros_support import as_action_failure, log_missing, next_message, system_of
from seoro.errors import ActionFailed
from seoro.robotics.moveit_goals import move_group_goal
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import MotionOptions
from seoro.runtime.contracts.ros2 import Members
from seoro.runtime.values.values import Actor

ROBOT_SEMANTICS = "robot_description_semantic"
MOVE_ACTION = "move_action"


async def move_group(
    ctx: ActionContext,
    action: str,
    group: str,
    constraints: dict[str, Any],
    options: MotionOptions,
    *,
    success_on_acceptance: bool = False,
) -> None:
    """Plan and move a group.

    Args:
        ctx: Context of the action.
        action: Full name of the ROS action.
        group: Planning group.
        constraints: Constraints of the goal.
        options: Speed, `plan_only` and `replan`.
        success_on_acceptance: Whether to return once the goal is accepted.

    Raises:
        ActionFailed: MoveIt rejects the goal, or reports an error.
    """
    goal = move_group_goal(group, constraints, options.scaling, plan_only=options.plan_only, replan=options.replan)
    await run_goal(ctx, action, "MoveGroup", goal, success_on_acceptance=success_on_acceptance)


async def run_goal(
    ctx: ActionContext, action: str, kind: str, goal: Mapping[str, Any], *, success_on_acceptance: bool = False
) -> None:
    """Send a goal to an action of MoveIt, and wait for its end.

    Raises:
        ActionFailed: MoveIt rejects the goal, or reports an error.
    """
    type_name = f"moveit_msgs/action/{kind}"
    await run_to_success(ctx, action, type_name, goal, success_on_acceptance=success_on_acceptance)


async def call_service(
    ctx: ActionContext, arm: Actor, namespace_override: str, name: str, kind: str, request: Members
) -> Members:
    """Call a service of MoveIt."""
    full = full_name(arm, namespace_override, name)
    return await call(ctx, full, f"moveit_msgs/srv/{kind}", request)


async def named_state(ctx: ActionContext, arm: Actor, namespace_override: str, group: str, name: str) -> Members:
    """Return the positions of the joints of a state that the SRDF of a robot names.

    Raises:
        ActionFailed: The SRDF is invalid, or has no such state.
    """
    topic = full_name(arm, namespace_override, ROBOT_SEMANTICS)
    with as_action_failure(), log_missing(ctx, lambda: f"the SRDF on {topic}"):
        async with system_of(ctx).subscribing(
            topic, "std_msgs/msg/String", "system_default_transient_local"
        ) as texts:
            text = str((await next_message(ctx, texts)).message.data)
    states = _states(text, topic, group)
    if name not in states:
        known = ", ".join(sorted(states)) or "none"
        raise ActionFailed(
            f"unknown state '{name}' of the group '{group}' in the SRDF on {topic} (states: {known})"
        )
    return states[name]


def _states(text: str, topic: str, group: str) -> Mapping[str, Mapping[str, float]]:
    """Return the states of a group in an SRDF: positions [rad, m] by joint, by state."""
    from xml.etree.ElementTree import ParseError  # noqa: PLC0415 - slow to load, and seldom needed

    from defusedxml import DefusedXmlException, ElementTree  # noqa: PLC0415 - the same

    try:
        return {
            str(state.get("name")): {
                str(joint.get("name")): float(str(joint.get("value"))) for joint in state.iter("joint")
            }
            for state in ElementTree.fromstring(text).iter("group_state")
            if state.get("group") == group
        }
    except (ParseError, DefusedXmlException, ValueError) as error:
        raise ActionFailed(f"invalid SRDF on {topic}: {error}") from None
