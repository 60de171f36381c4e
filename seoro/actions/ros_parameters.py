"""Parameters of ROS nodes that a simulator has a part for: those of a node that spoils laser scans.

A file that sets them on the node `laserscan_modification` runs in a simulator as it is. There the faults of the
robot's lidar are what the parameters say, and are measured like those of `osc.faults`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from seoro.actions.faults import inject
from seoro.errors import ActionFailed
from seoro.runtime.capabilities import Faults
from seoro.runtime.context import ActionContext
from seoro.runtime.device_faults import Amounts, BeamLoss, Fault, GaussianNoise

NODE = "laserscan_modification"
DEVICE = "lidar"
CONFIRM_WITHIN = 30.0  # [s]

PARAMETERS: Mapping[str, tuple[type[Fault], Callable[[float], Fault]]] = MappingProxyType(
    {
        "gaussian_noise_std_deviation": (GaussianNoise, lambda value: GaussianNoise(Amounts(length=value))),
        "random_drop_percentage": (BeamLoss, BeamLoss),  # a share, 0 to 1
    }
)


async def set_parameter(ctx: ActionContext, node_name: str, parameter_name: str, value: str) -> None:
    """Set a parameter of a node: zero clears the fault that it stands for, other values inject it.

    Raises:
        ActionFailed: There is no such node or parameter, or the fault was not found to take effect.
    """
    faults = ctx.anywhere(Faults)
    robot = _robot(faults, node_name)
    if parameter_name not in PARAMETERS:
        raise ActionFailed(
            f"the node `{node_name}` has no parameter `{parameter_name}` here: it has {', '.join(PARAMETERS)}"
        )
    kind, make = PARAMETERS[parameter_name]
    amount = _number(parameter_name, value)
    if amount == 0.0:
        await ctx.ask(faults.clear_faults(robot, DEVICE, kind))
    else:
        await inject(ctx, faults, robot, DEVICE, make(amount), CONFIRM_WITHIN)


def _robot(faults: Faults, node_name: str) -> str:
    """The robot whose scans a node spoils: that of its namespace, the first one without a namespace."""
    namespace, _, name = node_name.strip("/").rpartition("/")
    robots = [robot for robot, devices in faults.devices().items() if DEVICE in devices]
    if name != NODE or (namespace and namespace not in robots) or not robots:
        known = [f"`{NODE}`", *(f"`{robot}/{NODE}`" for robot in robots)] if robots else ["none"]
        raise ActionFailed(
            f"there is no node `{node_name}` here: of the nodes with parameters there are {', '.join(known)}"
        )
    return namespace or robots[0]


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ActionFailed(f"the parameter `{name}` is a number, not `{text}`") from None
