"""Records of the trace of a remote worker: a message for people, with the row of a run."""

from __future__ import annotations

from typing import Final

from seoro.campaign.runs import Row
from seoro.runtime.trace.jsonl import to_json

_ROW: Final = b', "row": '


def to_record(row: Row, time: float) -> bytes:
    """Encode a row as a record that `seoro attach` shows.

    Args:
        row: The row.
        time: Time since the begin of the worker [s].
    """
    message = f"run {row.run}: {row.status.value}"
    shown = to_json({"kind": "log", "t": round(time, 3), "level": "info", "message": message})
    return shown[:-1].encode() + _ROW + row.to_line().encode("utf-8", "backslashreplace").rstrip() + b"}\n"


def row_in(record: bytes) -> bytes:
    """Return the line of the row in a record; an invalid one if it has none."""
    return record.partition(_ROW)[2].rstrip().removesuffix(b"}")
