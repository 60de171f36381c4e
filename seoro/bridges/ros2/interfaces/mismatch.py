"""Errors of values that do not fit their types."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from seoro.bridges.ros2.interfaces.messages import Message


class Mismatch(Exception):
    """A value does not fit its type; the path grows while the error passes the enclosing structures."""

    def __init__(self, problem: str, help: str = "") -> None:  # noqa: A002
        super().__init__(problem)
        self.path = ""
        self.help = help

    def within(self, member: str) -> None:
        """Prepend a member, such as `position` or `[2]`, to the path."""
        self.path = member + ("" if not self.path or self.path.startswith("[") else ".") + self.path


def mismatch_of(expected: str, given: object, help: str = "") -> Mismatch:  # noqa: A002
    """Return the mismatch of an expected and a given value."""
    return Mismatch(f"expected {expected}, got {_description(given)}", help)


def _description(value: object) -> str:
    """Return a short description of a value."""
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
            return f"the string {_cut(repr(value))}"
        case _:
            return f"a {type(value).__name__}"


def _cut(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
