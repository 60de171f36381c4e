"""From messages to plain values, as YAML and JSON have them."""

from __future__ import annotations

from typing import Any

import numpy as np

from seoro.bridges.ros2.interfaces.messages import Message, attribute


def plain(message: Message) -> dict[str, Any]:
    """The members of a message as dictionaries, lists, numbers and texts. Not-a-number stays what it is."""
    return {name: _plain(getattr(message, attribute(name))) for name in message.__members__}


def _plain(value: Any) -> Any:
    match value:
        case Message():
            return plain(value)
        case np.ndarray():
            return value.tolist()
        case list():
            return [_plain(item) for item in value]
        case _:
            return value
