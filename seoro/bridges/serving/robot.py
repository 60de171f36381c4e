"""Interface of a robot to the node that serves it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Protocol

from seoro.bridges import wire
from seoro.bridges.leasing.emergency_stop import EmergencyStopState
from seoro.bridges.leasing.leases import Leases, display_name

Carry = Callable[[Any], Awaitable[wire.Message | None]]
"""Carries out a request and returns the reply; None stands for an empty one."""

Handlers = Mapping[wire.Verb[Any, Any], Carry]


class ServedRobot(Protocol):
    """Interface of a robot that a node serves."""

    @property
    def info(self) -> wire.RobotInfo:
        """Name, actor types and frames of the robot."""

    @property
    def health(self) -> wire.RobotHealth:
        """State of the robot."""

    @property
    def handlers(self) -> Handlers:
        """Handlers of the served verbs. The client receives each `RequestRefused` that they raise."""

    async def stop(self) -> None:
        """Command zero velocity, and cancel all goals on the robot. Called at any time; must return quickly."""


def robot_state(
    info: wire.RobotInfo, health: wire.RobotHealth, leases: Leases, emergency: EmergencyStopState
) -> wire.RobotState:
    """Return the state of a robot, its holder and its emergency stop."""
    hold = leases.holder_of(info.name)
    return wire.RobotState(
        name=info.name,
        kinds=info.kinds,
        **dict(health),
        holder="" if hold is None else display_name(hold.holder),
        lease=leases.lease_of(info.name),
        waiting=leases.waiting_for(info.name),
        stopped=emergency.robots.get(info.name),
    )
