"""Measurements of a run of a sweep, from its simulator and from `cover` and `record` of the scenario."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from seoro.files.inputs import Kind, open_input, read_input
from seoro.traces.reader import InvalidRecord, read_trace

MEASUREMENTS = "measurements.json"
TRACE = "trace.jsonl"


def measured(folder: Path) -> dict[str, object]:
    """Read the measurements of a run, by column.

    Args:
        folder: Folder of the run.

    Returns:
        Measurements of robots as `robot.name`, then the last sample of each item as `record.item` or `cover.item`.
        Parts of combinations have columns `record.item.part`.
    """
    return {**dict(_of_robots(folder / MEASUREMENTS)), **dict(_of_items(folder / TRACE))}


def _of_robots(path: Path) -> Iterator[tuple[str, object]]:
    """Yield the measurements of robots; a run without an end or a simulator has none."""
    try:
        robots = json.loads(read_input(path, Kind.OUTPUT))["robots"]
    except (OSError, ValueError, KeyError, TypeError):
        return
    for robot, values in robots.items():
        for name, value in values.items():
            yield f"{robot}.{name}", value


def _of_items(path: Path) -> Iterator[tuple[str, object]]:
    if not path.exists():
        return
    with open_input(path, Kind.TRACE) as file:
        for record in read_trace(file):
            if not isinstance(record, InvalidRecord) and record["kind"] in ("cover", "record"):
                yield from _columns(record)


def _columns(record: Mapping[str, Any]) -> Iterator[tuple[str, object]]:
    column, value = f"{record['kind']}.{record['item']}", record.get("value")
    if not isinstance(value, dict):
        yield column, value
        return
    for part, single in value.items():
        yield f"{column}.{part}", single
