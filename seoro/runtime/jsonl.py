"""JSON Lines: the records of a trace in a file, one JSON object a line (RFC 8259, UTF-8).

JSON has no word for floats that are not finite; they are the strings `NaN`, `Infinity` and `-Infinity`, as in
the JSON mapping of Protocol Buffers. A character that UTF-8 cannot hold (half of a surrogate pair, as in names of
files that are no valid UTF-8) is escaped.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any, Final

from seoro.runtime.writer import MOST_WAITING, ByteSink, Writer

_ENCODER: Final = json.JSONEncoder(ensure_ascii=False, allow_nan=False)  # to make one takes longer than a record


def to_json(value: object) -> str:
    """A value of plain data as JSON in one line.

    Raises:
        TypeError: It contains something that is no plain data.
    """
    try:
        return _ENCODER.encode(value)
    except ValueError:
        return _ENCODER.encode(_finite(value))


def to_line(record: dict[str, Any]) -> bytes:
    """A record as a line of a file."""
    # The replacement for what has no UTF-8, `\\udc80`, is what JSON has for it, too.
    return (to_json(record) + "\n").encode("utf-8", "backslashreplace")


def _finite(value: Any) -> object:
    match value:
        case float() if math.isnan(value):
            return "NaN"
        case float() if math.isinf(value):
            return "Infinity" if value > 0 else "-Infinity"
        case dict():
            return {key: _finite(part) for key, part in value.items()}
        case list() | tuple():
            return [_finite(part) for part in value]
        case _:
            return value


class JsonLines:
    """Writes records to a file, without holding up the run (see `writer.py`).

    Args:
        file: Takes the lines.
        name: Of the file, for messages.
        most_waiting: How many records may wait for a slow file.
    """

    def __init__(self, file: ByteSink, name: str, most_waiting: int = MOST_WAITING) -> None:
        self._writer = Writer(file, name, to_line, most_waiting)
        self.record = self._writer.put  # an observer of the trace

    def when_failed(self, tell: Callable[[Exception], object]) -> None:
        """Have something called, in another thread, as soon as records cannot be written."""
        self._writer.on_error = tell

    async def finish(self) -> None:
        """Wait until all records are in the file.

        Raises:
            OSError: They cannot be written; the message says why.
        """
        await self._writer.finish()
