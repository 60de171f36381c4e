"""A page's side of frames: joins them to the data of the whole run."""

from __future__ import annotations

import json
import struct
import zlib
from typing import Any

TABLES = ("entities", "beams", "series", "rows", "strings", "margins", "samples")
WIDTHS = {"i4": 4, "f8": 8, "u1": 1}
ENDED = {"ended.end": "behaviors.end", "ended.status": "behaviors.status", "ended.reason": "behaviors.reason"}


class Joined:
    """Data of all frames until now.

    Attributes:
        fields: Fields of the objects, and their tables.
        columns: Columns by name.
    """

    def __init__(self) -> None:
        self.fields: dict[str, Any] = {}
        self.columns: dict[str, list[float]] = {}

    def add(self, message: bytes) -> None:
        """Add a frame."""
        fields, data = split(message)
        columns = decode(data, fields.pop("layout"))
        if fields.pop("first"):
            self.fields, self.columns = {}, {}
        for name in TABLES:
            self.fields.setdefault(name, []).extend(fields.pop(name))
        blocks = self.fields.setdefault("blocks", [])
        for block in fields.pop("blocks"):
            blocks[block[3] :] = [block]
        self.fields |= fields
        ended = {name: columns.pop(name) for name in list(columns) if name.startswith("ended.")}
        for place, index in enumerate(ended.get("ended.index", ())):
            for name, target in {**ENDED, "ended.endSeq": "behaviors.endSeq"}.items():
                self.columns[target][int(index)] = ended[name][place]
        for name, column in columns.items():
            self.columns.setdefault(name, []).extend(column)
        for index, seq in enumerate(self.columns.get("behaviors.endSeq", ())):
            if seq < 0:  # it is running
                start = self.columns["behaviors.start"][index]
                self.columns["behaviors.end"][index] = max(start, self.fields["time"])


def split(message: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the object and the columns of a frame."""
    start = len(message) - 4 - int.from_bytes(message[-4:], "little")
    fields: dict[str, Any] = json.loads(message[start:-4])
    return fields, message[:start]


def decode(data: bytes, layout: dict[str, tuple[str, int]]) -> dict[str, list[float]]:
    """Decode columns."""
    found: dict[str, list[float]] = {}
    offset = 0
    for name, (code, length) in layout.items():
        type_, count = (code[1:], 1) if code.startswith("=") else (code, length)
        width = WIDTHS[type_]
        planes = data[offset : offset + width * count]
        offset += width * count
        raw = b"".join(bytes(planes[index::count]) for index in range(count))
        values: list[float] = [
            value for (value,) in struct.iter_unpack({"i4": "<i", "f8": "<d", "u1": "<B"}[type_], raw)
        ]
        if type_ == "i4":
            for index in range(1, count):
                values[index] += values[index - 1]
        found[name] = values * length if code.startswith("=") else values
    assert offset == len(data)
    return found


def lines_of(block: bytes) -> list[bytes]:
    """Return the lines of a block."""
    return zlib.decompress(block).split(b"\n")
