"""Actions of `osc.ros` that ask somebody for something: services, actions, parameters."""

from __future__ import annotations

import time
from contextlib import AbstractAsyncContextManager

from seoro.actions.reports import meanwhile
from seoro.actions.ros_parameters import set_parameter
from seoro.actions.ros_support import Target, as_text, failing, member, shown, store, system_of, to_members
from seoro.errors import ActionFailed
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Faults
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import GoalStatus
from seoro.runtime.ros_system import GoalResult, Members, Ros2System, RosGoal, Wanted
from seoro.runtime.values import Variable

FEEDBACK_PERIOD = 1.0  # [s] between messages of the trace that tell of the feedback of a goal


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
    # `transient_local` is met in any case: a request is sent when there is a server to take it.
    request = to_members(data, f"a request to {service_name}")
    _note_absence(ctx, Wanted("service", service_name))
    with failing():
        response = await meanwhile(ctx, system_of(ctx).call(service_name, service_type, request))
    what = f"the response of {service_name}"
    ctx.log(f"{what}: {shown(response)}", "debug")
    _keep(ctx, response_variable, response, response_member_name, what)


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
    """Send a goal to an action, and wait for its end; it is canceled when this is."""
    if success_on_acceptance and isinstance(result_variable, Variable):
        raise ActionFailed("with `success_on_acceptance` there is no result that `result_variable` could hold")
    goal = to_members(data, f"a goal of {action_name}")
    _note_absence(ctx, Wanted("action", action_name))
    feedback = _Feedback(ctx, action_name).take
    pursuing = system_of(ctx).pursuing(
        action_name,
        action_type,
        goal,
        feedback,
        lambda text: ctx.relay([text], "warning"),
        late=transient_local,
    )
    with failing():
        if success_on_acceptance:
            await meanwhile(ctx, ctx.keep(pursuing))
            return
        result = await meanwhile(ctx, _end_of(pursuing))
    what = f"the result of {action_name}"
    if result.status is not GoalStatus.SUCCEEDED:
        raise ActionFailed(f"the goal of {action_name} was {result.status.value}; {what}: {shown(result.result)}")
    _keep(ctx, result_variable, result.result, result_member_name, what)


async def _end_of(pursuing: AbstractAsyncContextManager[RosGoal]) -> GoalResult:
    async with pursuing as goal:
        return await goal.ended()


class _Feedback:
    """Writes feedback into the trace: the first of a goal, and no more than one a second after that.

    Args:
        ctx: Of the action.
        name: Of the ROS action.
    """

    def __init__(self, ctx: ActionContext, name: str) -> None:
        self._ctx = ctx
        self._name = name
        self._told = -FEEDBACK_PERIOD

    def take(self, feedback: Members) -> None:
        """Feedback has come."""
        now = time.monotonic()
        if now - self._told >= FEEDBACK_PERIOD:
            self._told = now
            self._ctx.relay([f"feedback of {self._name}: {shown(feedback)}"], "debug")


def _note_absence(ctx: ActionContext, wanted: Wanted) -> None:
    """Say that a server is waited for, if there is none."""
    with failing():
        for missing in system_of(ctx).missing([wanted]):
            ctx.log(f"waiting for the {missing}")


def _keep(ctx: ActionContext, target: Target, found: Members, path: str, what: str) -> None:
    if path and not isinstance(target, Variable):
        raise ActionFailed(f"there is no variable to hold `{path}` of {what}")
    if isinstance(target, Variable):
        store(ctx, target, member(found, path, what), f"`{path}` of {what}" if path else what)


@action("set_node_parameter", anywhere=Ros2System | Faults)
async def set_node_parameter(
    ctx: ActionContext, node_name: str, parameter_name: str, parameter_value: object
) -> None:
    """Set a parameter of a node; without a ROS 2 system, of a node that a simulator has a part for."""
    text = as_text(parameter_value)
    system = ctx.find(Ros2System)
    if system is None:
        await set_parameter(ctx, node_name, parameter_name, text)
        return
    with failing():
        await meanwhile(ctx, system.set_parameter(node_name, parameter_name, text))
