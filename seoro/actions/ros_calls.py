"""Actions of `osc.ros` that send requests: services, actions, parameters."""

from __future__ import annotations

from seoro.actions.reports import meanwhile
from seoro.actions.ros_parameters import set_parameter
from seoro.actions.ros_requests import call, send_goal, store_member
from seoro.actions.ros_support import as_action_failure, as_text, to_members
from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.contracts.sensors import Faults
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Variable


@action("service_call", anywhere=Ros2System, ros={"service_name": "name", "service_type": "srv"})
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
    response = await call(ctx, service_name, service_type, request)
    store_member(ctx, response_variable, response, response_member_name, f"the response of {service_name}")


@action("action_call", anywhere=Ros2System, ros={"action_name": "name", "action_type": "action"})
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
    result = await send_goal(
        ctx, action_name, action_type, goal, success_on_acceptance=success_on_acceptance, late=transient_local
    )
    if result is not None:
        store_member(ctx, result_variable, result, result_member_name, f"the result of {action_name}")


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
