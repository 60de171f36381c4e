"""Messages as mappings of members."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.interfaces.messages import attribute


class Members(Mapping[str, Any]):
    """Mapping of the members of a message to plain values, converted on access.

    Args:
        message: The message.
    """

    __slots__ = ("message",)

    def __init__(self, message: Message) -> None:
        self.message = message

    def __getitem__(self, name: str) -> Any:
        if name not in self.message.__members__:
            raise KeyError(name)
        return _plain(getattr(self.message, attribute(name)))

    def __contains__(self, name: object) -> bool:
        return name in self.message.__members__

    def __iter__(self) -> Iterator[str]:
        return iter(self.message.__members__)

    def __len__(self) -> int:
        return len(self.message.__members__)

    def __repr__(self) -> str:
        return repr(dict(self))


def _plain(value: Any) -> Any:
    match value:
        case Message():
            return Members(value)
        case np.ndarray() | np.generic():
            return value.tolist()
        case list() | tuple():
            return [_plain(item) for item in value]
        case _:
            return value


@dataclass(slots=True)
class ReceivedMessage:
    """A received message.

    Args:
        message: The decoded message.
        arrived: Time of arrival [s since the epoch].
    """

    message: Any
    arrived: float

    @property
    def members(self) -> Members:
        """Members of the message."""
        return Members(self.message)
