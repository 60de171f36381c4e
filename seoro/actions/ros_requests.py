"""Requests to a ROS 2 system: calls of services, and goals of actions, with the reasons of failures."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from seoro.actions.reports import meanwhile
from seoro.actions.ros_support import as_action_failure, member, shown, store, system_of
from seoro.errors import ActionFailed
from seoro.robotics.goal_results import describe_failure
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.ros2 import GoalResult, Members, RosGoal, Wanted
from seoro.runtime.values.values import Variable

FEEDBACK_PERIOD = 1.0  # [s] between logs of the feedback of a goal


async def call(ctx: ActionContext, service: str, type_name: str, request: Members) -> Members:
    """Call a service once it has a server, and return the response.

    Raises:
        ActionFailed: The server fails or disappears, or the request is invalid.
    """
    _note_absence(ctx, Wanted("service", service))
    with as_action_failure():
        response = await meanwhile(ctx, system_of(ctx).call(service, type_name, request))
    ctx.log(f"the response of {service}: {shown(response)}", "debug")
    return response


async def send_goal(
    ctx: ActionContext,
    action: str,
    type_name: str,
    goal: Members,
    *,
    success_on_acceptance: bool = False,
    late: bool = False,
) -> Members | None:
    """Send a goal to an action once it has a server, and wait for its end; cancellation cancels the goal.

    Args:
        ctx: Context of the action.
        action: Name of the ROS action.
        type_name: Its type.
        goal: Members of the goal.
        success_on_acceptance: Whether to return None once the goal is accepted; it ends with the run.
        late: Whether to request feedback that was published before.

    Raises:
        ActionFailed: The goal is invalid, or the server rejects, aborts or cancels it, or disappears.
    """
    _note_absence(ctx, Wanted("action", action))
    sending = system_of(ctx).sending_goal(
        action,
        type_name,
        goal,
        _feedback_logger(ctx, action),
        lambda text: ctx.relay([text], "warning"),
        late=late,
    )
    with as_action_failure():
        if success_on_acceptance:
            await meanwhile(ctx, ctx.keep(sending))
            return None
        end = await meanwhile(ctx, _wait_for_result(sending))
    if end.status is not GoalStatus.SUCCEEDED:
        reason = describe_failure(type_name.replace(".", "/"), end.result)
        found = reason or f"the result of {action}: {shown(end.result)}"
        separator = ": " if reason else "; "
        raise ActionFailed(f"the goal of {action} was {end.status.value}{separator}{found}")
    return end.result


async def run_to_success(
    ctx: ActionContext, action: str, type_name: str, goal: Members, *, success_on_acceptance: bool = False
) -> Members | None:
    """Send a goal as `send_goal` does; a result that states an error is a failure, too.

    Raises:
        ActionFailed: See `send_goal`; also if Nav2 or MoveIt report a failure by the result only.
    """
    result = await send_goal(ctx, action, type_name, goal, success_on_acceptance=success_on_acceptance)
    if result is not None and (failure := describe_failure(type_name, result)):
        raise ActionFailed(f"{action}: {failure}")
    return result


async def _wait_for_result(sending: AbstractAsyncContextManager[RosGoal]) -> GoalResult:
    async with sending as goal:
        return await goal.ended()


def _feedback_logger(ctx: ActionContext, name: str) -> Callable[[Members], None]:
    """Return a function that logs the feedback of a goal of an action, at most once per second."""
    logged = -FEEDBACK_PERIOD

    def log(feedback: Members) -> None:
        nonlocal logged
        now = time.monotonic()
        if now - logged >= FEEDBACK_PERIOD:
            logged = now
            ctx.relay([f"feedback of {name}: {shown(feedback)}"], "debug")

    return log


def _note_absence(ctx: ActionContext, wanted: Wanted) -> None:
    """Log that the action waits for a server, if none exists."""
    with as_action_failure():
        for missing in system_of(ctx).missing([wanted]):
            ctx.log(f"waiting for the {missing}")


def store_member(ctx: ActionContext, target: Variable[object] | str, found: Members, path: str, what: str) -> None:
    """Store a member of a received message in a variable, if one is given.

    Args:
        ctx: Context of the action.
        target: The variable, or the declared default for none.
        found: The message.
        path: Path of the member; empty for the whole message.
        what: Name of the message for errors.

    Raises:
        ActionFailed: The member is missing, or the variable does not fit.
    """
    if isinstance(target, Variable):
        store(ctx, target, member(found, path, what), f"`{path}` of {what}" if path else what)
    elif path:
        raise ActionFailed(f"no variable given for `{path}` of {what}; set the parameter for the variable")
