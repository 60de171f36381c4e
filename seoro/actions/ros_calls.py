"""Actions of `osc.ros` that send requests: services, actions, parameters."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from seoro.actions.reports import meanwhile
from seoro.actions.ros_parameters import set_parameter
from seoro.actions.ros_support import as_action_failure, as_text, member, shown, store, system_of, to_members
from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.ros2 import GoalResult, Members, Ros2System, RosGoal, Wanted
from seoro.runtime.contracts.sensors import Faults
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Variable

FEEDBACK_PERIOD = 1.0  # [s] between logs of the feedback of a goal


@action("service_call", anywhere=Ros2System)
async def service_call(
    ctx: ActionContext,
    service_name: str,
    service_type: str,
    data: object,
    transient_local: bool,
    response_variable: Variable[object] | str,
    response_member_name: str,
) -> None:
    """Call a service and wait for its response."""
    # `transient_local` always holds: the request is sent once a server exists.
    request = to_members(data, f"a request to {service_name}")
    _note_absence(ctx, Wanted("service", service_name))
    with as_action_failure():
        response = await meanwhile(ctx, system_of(ctx).call(service_name, service_type, request))
    what = f"the response of {service_name}"
    ctx.log(f"{what}: {shown(response)}", "debug")
    _store_member(ctx, response_variable, response, response_member_name, what)


@action("action_call", anywhere=Ros2System)
async def action_call(
    ctx: ActionContext,
    action_name: str,
    action_type: str,
    data: object,
    success_on_acceptance: bool,
    transient_local: bool,
    result_variable: Variable[object] | str,
    result_member_name: str,
) -> None:
    """Send a goal to an action and wait for its end; cancellation cancels the goal."""
    if success_on_acceptance and isinstance(result_variable, Variable):
        raise ActionFailed("`success_on_acceptance` excludes `result_variable`: it waits for no result; omit one")
    goal = to_members(data, f"a goal of {action_name}")
    _note_absence(ctx, Wanted("action", action_name))
    feedback = _feedback_logger(ctx, action_name)
    sending = system_of(ctx).sending_goal(
        action_name,
        action_type,
        goal,
        feedback,
        lambda text: ctx.relay([text], "warning"),
        late=transient_local,
    )
    with as_action_failure():
        if success_on_acceptance:
            await meanwhile(ctx, ctx.keep(sending))
            return
        result = await meanwhile(ctx, _wait_for_result(sending))
    what = f"the result of {action_name}"
    if result.status is not GoalStatus.SUCCEEDED:
        raise ActionFailed(f"the goal of {action_name} was {result.status.value}; {what}: {shown(result.result)}")
    _store_member(ctx, result_variable, result.result, result_member_name, what)


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


def _store_member(
    ctx: ActionContext, target: Variable[object] | str, found: Members, path: str, what: str
) -> None:
    if isinstance(target, Variable):  # not the declared default for none
        store(ctx, target, member(found, path, what), f"`{path}` of {what}" if path else what)
    elif path:
        raise ActionFailed(f"no variable given for `{path}` of {what}; set the parameter for the variable")


@action("set_node_parameter", anywhere=Ros2System | Faults)
async def set_node_parameter(
    ctx: ActionContext, node_name: str, parameter_name: str, parameter_value: object
) -> None:
    """Set a parameter of a node; without a ROS 2 system, of a node emulated by the simulator."""
    text = as_text(parameter_value)
    system = ctx.find(Ros2System)
    if system is None:
        await set_parameter(ctx, node_name, parameter_name, text)
        return
    with as_action_failure():
        await meanwhile(ctx, system.set_parameter(node_name, parameter_name, text))
