"""JSON Lines: trace records in a file, one JSON object per line (RFC 8259, UTF-8).

Floats that are not finite become the strings `NaN`, `Infinity` and `-Infinity`, as in the JSON mapping of Protocol
Buffers. Characters that UTF-8 cannot encode (half of a surrogate pair, as in file names that are not valid UTF-8)
are escaped.
"""

from __future__ import annotations

import json
import math
from typing import Any, Final

from seoro.runtime.trace.writer import MOST_WAITING, ByteSink, Writer

_ENCODER: Final = json.JSONEncoder(ensure_ascii=False, allow_nan=False)  # creating one takes longer than using it


def to_json(value: object) -> str:
    """Encode plain data as JSON in one line.

    Raises:
        TypeError: It contains other data.
    """
    try:
        return _ENCODER.encode(value)
    except ValueError:
        return _ENCODER.encode(_finite(value))


def to_line(record: dict[str, Any]) -> bytes:
    """Encode a record as a line of a file."""
    # The replacement for characters without UTF-8, `\\udc80`, is also valid JSON.
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


class JsonLines(Writer[dict[str, Any]]):
    """Writes records to a file without delaying the run (see `writer.py`).

    Args:
        file: The file.
        name: Its name, for messages.
        most_waiting: Maximum number of records that wait for a slow file.
    """

    def __init__(self, file: ByteSink, name: str, most_waiting: int = MOST_WAITING) -> None:
        super().__init__(file, name, to_line, most_waiting)

    record = Writer[dict[str, Any]].put  # an observer of the trace
