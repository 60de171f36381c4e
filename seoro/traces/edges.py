"""First and last record of a trace, without reading the records between."""

from __future__ import annotations

import json
from typing import IO, Final

from seoro.traces.reader import Record

_LONGEST_START: Final = 16 << 20  # [bytes] of a `run.start`, which has the texts of all files
_TAILS: Final = (16 << 10, 1 << 20)  # [bytes] at the end of a trace that have its `run.end`


def read_start(file: IO[bytes]) -> Record | None:
    """Return the record `run.start` of a trace; None if it is missing or incomplete."""
    file.seek(0)
    return _record(file.readline(_LONGEST_START), "run.start")


def read_robots(file: IO[bytes], start: Record) -> tuple[str, ...]:
    """Return the names of the robots of a run, as its first records have them: its scene, or those of a lab.

    Args:
        file: The trace.
        start: Its record `run.start`.
    """
    file.seek(0)
    file.readline(_LONGEST_START)
    scene = _record(file.readline(_LONGEST_START), "scene") or {}
    entities = scene.get("entities")
    found = [each for each in entities if isinstance(each, dict)] if isinstance(entities, list) else []
    names = [str(each.get("name")) for each in found if each.get("kind") == "robot"]
    assigned = start.get("robots")
    return tuple(names or (assigned if isinstance(assigned, dict) else ()))


def read_end(file: IO[bytes]) -> Record | None:
    """Return the record `run.end` of a trace; None if it is missing or incomplete."""
    size = file.seek(0, 2)
    for tail in _TAILS:
        file.seek(max(0, size - tail))
        _, separator, last = file.read(tail).rstrip().rpartition(b"\n")
        if separator or size <= tail:
            return _record(last, "run.end")
    return None


def _record(line: bytes, kind: str) -> Record | None:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) and found.get("kind") == kind else None
