"""What a robot offers to the node that serves it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Protocol

from seoro.bridges import wire
from seoro.bridges.leasing.latch import Latch
from seoro.bridges.leasing.leases import Leases, called

Carry = Callable[[Any], Awaitable[wire.Message]]
"""Carries out a request, a message of the verb's model, and returns the answer."""

Handlers = Mapping[wire.Verb[Any, Any], Carry]


@dataclass(frozen=True)
class Health:
    """How a robot is, as far as that is known; see `wire.RobotState` for what the parts mean."""

    battery: float | None = None
    localised: bool | None = None
    deviation: float | None = None
    position: tuple[float, float] | None = None
    seen: float | None = None
    topics: tuple[wire.TopicState, ...] = ()


class ServedRobot(Protocol):
    """A robot that is reached, with whatever speaks to it."""

    @property
    def info(self) -> wire.RobotInfo:
        """Its name, what actors it can stand for, and the frames that it has."""
        ...

    @property
    def health(self) -> Health:
        """How it is."""
        ...

    @property
    def handlers(self) -> Handlers:
        """The verbs that it serves. What they raise as `RequestRefused` is told to the client."""
        ...

    async def stop(self) -> None:
        """Command zero velocity, and cancel what the robot itself works on. Called at any time; must be quick."""
        ...


def state_of(info: wire.RobotInfo, health: Health, leases: Leases, latch: Latch) -> wire.RobotState:
    """How a robot is, who has it, and whether an emergency stop of it holds."""
    hold = leases.holder_of(info.name)
    return wire.RobotState(
        name=info.name,
        kinds=info.kinds,
        **asdict(health),
        holder="" if hold is None else called(hold.holder),
        lease=leases.lease_of(info.name),
        waiting=leases.waiting_for(info.name),
        stopped=latch.robots.get(info.name),
    )
