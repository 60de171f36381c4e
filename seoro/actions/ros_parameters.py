"""Parameters of ROS nodes emulated by a simulator: those of a node that disturbs laser scans.

Scenarios that set them on the node `laserscan_modification` run in a simulator unchanged. The parameters become
faults of the robot's lidar, and are measured like those of `osc.faults`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from seoro.actions.faults import inject
from seoro.errors import ActionFailed
from seoro.robotics.faults import BeamLoss, Fault, GaussianNoise, Quantity
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.sensors import Faults

NODE = "laserscan_modification"
DEVICE = "lidar"
CONFIRM_WITHIN = 30.0  # [s]

PARAMETERS: Mapping[str, tuple[type[Fault], Callable[[float], Fault]]] = MappingProxyType(
    {
        "gaussian_noise_std_deviation": (GaussianNoise, lambda value: GaussianNoise({Quantity.LENGTH: value})),
        "random_drop_percentage": (BeamLoss, BeamLoss),  # a share, 0 to 1
    }
)


async def set_parameter(ctx: ActionContext, node_name: str, parameter_name: str, value: str) -> None:
    """Set a parameter of a node: zero clears its fault, other values inject it.

    Raises:
        ActionFailed: The node or the parameter is unknown, or no effect was measured.
    """
    faults = ctx.anywhere(Faults)
    robot = _robot(faults, node_name)
    if parameter_name not in PARAMETERS:
        raise ActionFailed(
            f"unknown parameter `{parameter_name}` of the node `{node_name}` (parameters: {', '.join(PARAMETERS)})"
        )
    kind, make = PARAMETERS[parameter_name]
    amount = _number(parameter_name, value)
    if amount == 0.0:
        await ctx.ask(faults.clear_faults(robot, DEVICE, kind))
    else:
        await inject(ctx, faults, robot, DEVICE, make(amount), CONFIRM_WITHIN)


def _robot(faults: Faults, node_name: str) -> str:
    """Return the robot of a node: that of its namespace, or the first one without a namespace."""
    namespace, _, name = node_name.strip("/").rpartition("/")
    robots = [robot for robot, devices in faults.devices().items() if DEVICE in devices]
    if name != NODE or (namespace and namespace not in robots) or not robots:
        known = [f"`{NODE}`", *(f"`{robot}/{NODE}`" for robot in robots)] if robots else ["none"]
        raise ActionFailed(f"unknown node `{node_name}` (nodes with parameters: {', '.join(known)})")
    return namespace or robots[0]


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ActionFailed(f"invalid value of the parameter `{name}`: expected a number, found `{text}`") from None
