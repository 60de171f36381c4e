"""Data of a run for a page: everything, or the changes since the previous frame.

A frame has a JSON object, and columns. The first frame of a page has all fields. Later ones have new rows of the
tables, the fields that changed, and, as columns `ended.*`, the ends of behaviors that were running before.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from seoro.report.blocks import KINDS
from seoro.report.columns import BEGIN, STEP, Packed, Position
from seoro.report.folder import Results
from seoro.report.reading import Reading
from seoro.report.repeat import repeat_command
from seoro.report.rows import STATUSES

RUNNING: Final = "running"
KILLED: Final = "killed"


class Frame:
    """Data of a run.

    Args:
        reading: Data of its trace.
        results: Results beside the trace.
        write: Receives the bytes of the columns, in the order of the field `layout`.
        since: Position of the frame before; without one, the frame has everything.

    Attributes:
        text: The object, as JSON.
        position: Position of this frame.
    """

    def __init__(
        self, reading: Reading, results: Results, write: Callable[[bytes], object], since: Position = BEGIN
    ) -> None:
        packed = Packed(write, since)
        fields = {"first": since is BEGIN, "layout": packed.layout} | _tables(reading, packed)
        changes = {
            name: value for name, value in _single(reading, results).items() if packed.has_changed(name, value)
        }
        self.text = _json(fields | changes)
        self.position: Position = packed.position


def status_of(reading: Reading) -> str:
    """Return the status of a run: as its trace has it, `running`, or `killed`."""
    if reading.end is not None:
        return str(reading.end["status"])
    return KILLED if reading.is_finished else RUNNING


def command_of(reading: Reading) -> str:
    """Return the command that repeats the run; empty without a start."""
    return "" if reading.start is None else repeat_command(reading.start, reading.scene or {})


def _tables(reading: Reading, packed: Packed) -> dict[str, Any]:
    """Pack the columns, and return the other tables."""
    reading.behaviors.pack(packed, reading.time)
    events = ("t", reading.event_times), ("name", reading.event_names), ("seq", reading.event_seqs)
    packed.add_table("events", events)
    return {
        "entities": reading.tracks.pack(packed),
        "links": packed.rest("links", reading.tracks.links),
        "beams": packed.rest("beams", reading.tracks.beams),
        "series": reading.series.pack(packed),
        "rows": [row.plain() for row in packed.rest("rows", reading.behaviors.rows)],
        "strings": packed.rest("strings", reading.strings.texts),
        "blocks": reading.blocks.pack(packed),
        "margins": packed.rest("margins", reading.margins),
        "samples": packed.rest("samples", reading.samples),
    }


def _single(reading: Reading, results: Results) -> Mapping[str, Any]:
    """Return the fields that are sent again only if they changed."""
    return {
        "kinds": KINDS,
        "statuses": STATUSES,
        "step": STEP,
        "start": reading.start,
        "end": reading.end,
        "scene": reading.scene,
        "sources": reading.sources,
        "tree": reading.tree,
        "time": reading.time,
        "count": reading.count,
        "counts": dict(reading.kinds),
        "status": status_of(reading),
        "notes": list(_notes(reading)),
        "command": command_of(reading),
        "measurements": results.measurements,
        "coverage": results.coverage,
    }


def _notes(reading: Reading) -> Iterator[str]:
    """Yield sentences about what the page cannot show."""
    if reading.start is not None and "bag" in reading.start:
        yield "The trace was made from a bag. It has no verdict."
    elif reading.end is None and reading.is_finished:
        cut = " Its last line is incomplete." if reading.is_cut else ""
        yield f"The trace has no end: the run was killed, or is still active.{cut}"
    if reading.start is None and reading.count:
        yield "The trace has no beginning: records are missing."
    if reading.further_runs:
        yield "The file has more runs. This report shows the first one."
    for problem in reading.problems:
        yield f"Invalid {problem}"
    omitted = (
        (reading.behaviors.omitted, "behaviors share the row of their parent"),
        (reading.series.omitted, "values of further series"),
        (reading.tracks.omitted, "samples of poses, paths and scans"),
    )
    for number, what in omitted:
        if number:
            yield f"Left out: {number:,} {what}."


def _json(value: object) -> bytes:
    try:
        text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    except ValueError:  # NaN and infinity, which traces of other writers may have
        text = json.dumps(_finite(value), ensure_ascii=False)
    return text.encode("utf-8", "replace")


def _finite(value: object) -> object:
    match value:
        case float() if not math.isfinite(value):
            return str(value)
        case dict():
            return {name: _finite(part) for name, part in value.items()}
        case list() | tuple():
            return [_finite(part) for part in value]
        case _:
            return value
