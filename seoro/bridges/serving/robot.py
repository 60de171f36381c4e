"""What a robot offers to the node that serves it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Protocol

from seoro.bridges import wire

Carry = Callable[[Any], Awaitable[wire.Message]]
"""Carries out a request, a message of the verb's model, and returns the answer."""

Handlers = Mapping[wire.Verb[Any, Any], Carry]


class ServedRobot(Protocol):
    """A robot that is reached, with whatever speaks to it."""

    @property
    def info(self) -> wire.RobotInfo:
        """Its name, what actors it can stand for, and the frames that it has."""
        ...

    @property
    def handlers(self) -> Handlers:
        """The verbs that it serves. What they raise as `RequestRefused` is told to the client."""
        ...

    async def stop(self) -> None:
        """Command zero velocity, and cancel what the robot itself works on. Called at any time; must be quick."""
        ...
