"""Why a value does not fit, in words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from seoro.bridges.ros2.interfaces.messages import Message


class Mismatch(Exception):
    """A value does not fit; the path grows while the error leaves the structures."""

    def __init__(self, expected: str, given: object, help: str = "") -> None:  # noqa: A002
        super().__init__(f"expected {expected}, got {_shown(given)}")
        self.path = ""
        self.help = help

    def within(self, member: str) -> None:
        """The value was that of a member, such as `position` or `[2]`."""
        self.path = member + ("" if not self.path or self.path.startswith("[") else ".") + self.path


class Unknown:
    """A name that is no member; shown as what was given."""

    def __init__(self, name: object) -> None:
        self._name = name

    def __repr__(self) -> str:
        return f"an unknown one, `{self._name}`"


class Count:
    """A number of elements; shown as what was given."""

    def __init__(self, count: int) -> None:
        self._count = count

    def __repr__(self) -> str:
        return str(self._count)


def _shown(value: object) -> str:
    """A value in a message, short."""
    match value:
        case Unknown() | Count():
            return repr(value)
        case None:
            return "nothing"
        case bool():
            return str(value).lower()
        case Message():
            return f"a {value.__msgtype__}"
        case np.ndarray():
            return f"an array of {value.dtype} with the shape {value.shape}"
        case Mapping():
            return f"a mapping with {len(value)} entries"
        case list() | tuple():
            return f"a list of {len(value)}"
        case bytes() | bytearray() | memoryview():
            return f"{len(value)} bytes"
        case int() | float():
            return _cut(repr(value)) if not isinstance(value, int) or value.bit_length() < 256 else "a huge number"
        case str():
            return f"the text {_cut(repr(value))}"
        case _:
            return f"a {type(value).__name__}"


def _cut(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
