"""Why a value does not fit, in words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from seoro.bridges.ros2.interfaces.messages import Message


class Mismatch(Exception):
    """A value does not fit; the path grows while the error leaves the structures."""

    def __init__(self, problem: str, help: str = "") -> None:  # noqa: A002
        super().__init__(problem)
        self.path = ""
        self.help = help

    def within(self, member: str) -> None:
        """The value was that of a member, such as `position` or `[2]`."""
        self.path = member + ("" if not self.path or self.path.startswith("[") else ".") + self.path


def unfit(expected: str, given: object, help: str = "") -> Mismatch:  # noqa: A002
    """The mismatch of a value that is not what was expected."""
    return Mismatch(f"expected {expected}, got {_shown(given)}", help)


def _shown(value: object) -> str:
    """A value in a message, short."""
    match value:
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
