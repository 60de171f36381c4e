"""Results of a sweep: a table with a line per run (parameters, status, measurements), and JUnit XML."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from seoro.files.inputs import Kind, open_input, read_input
from seoro.runtime.trace.junit import TAGS, Case, junit
from seoro.sweep.running import Ran
from seoro.traces.reader import InvalidRecord, read_trace

TABLE = "results.csv"
JUNIT = "test.xml"
MEASUREMENTS = "measurements.json"
TRACE = "trace.jsonl"


def write_results(ran: Sequence[Ran], folder: Path, file: str) -> tuple[Path, Path]:
    """Write the table and the JUnit file.

    Args:
        ran: Ended runs, in any order.
        folder: Output folder.
        file: Scenario file, as the user named it.

    Returns:
        The table and the JUnit file.
    """
    in_order = sorted(ran, key=lambda each: each.planned.number)
    axes = list(in_order[0].planned.values) if in_order else []
    found = [measured(each.planned.folder) for each in in_order]
    columns = list(dict.fromkeys(column for each in found for column in each))
    table = folder / TABLE
    with table.open("w", newline="", encoding="utf-8") as opened:
        writer = csv.writer(opened)
        ending = ["seed", "status", "duration", "wall_duration", "reason", "folder"]
        writer.writerow(["run", *axes, *ending, *columns])
        for each, has in zip(in_order, found, strict=True):
            planned = each.planned
            values = [_value(each, path) for path in axes]
            ended = [planned.seed, each.status.value, each.duration, round(each.wall_duration, 3), each.reason]
            place = planned.folder.relative_to(folder)
            writer.writerow([planned.number, *values, *ended, place, *(has.get(column) for column in columns)])
    report = folder / JUNIT
    report.write_text(junit([_case(each, file) for each in in_order]), encoding="utf-8")
    return table, report


def _value(ran: Ran, path: str) -> object:
    """Return a parameter in SI units; for invocations and failed starts, as the scenario writes it."""
    value: object = ran.parameters
    for name in path.split("."):
        if not isinstance(value, dict) or name not in value:
            return _bare(ran.planned.values[path])
        value = value[name]
    return value


def _bare(text: str) -> str:
    """Strip the quotes of a string literal."""
    is_string = len(text) > 1 and text[0] == text[-1] and text[0] in "'\""
    return text[1:-1] if is_string else text


def _case(ran: Ran, file: str) -> Case:
    return Case(
        name=f"{ran.planned.number}: {ran.planned.title}",
        file=file,
        tag=TAGS.get(ran.status),
        kind=ran.status.value,
        message=ran.reason,
        text=ran.reason,
        duration=ran.wall_duration,
        properties={
            "seed": ran.planned.seed,
            "duration": ran.duration,
            **{f"parameter.{path}": _value(ran, path) for path in ran.planned.values},
        },
    )


# ---------------------------------------------------------------- measurements of the simulator and the scenario


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
    """Yield the measurements of robots and entities; a run without an end or a simulator has none."""
    try:
        measured = json.loads(read_input(path, Kind.OUTPUT))
        found = {**measured["robots"], **measured.get("entities", {})}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return
    for entity, values in found.items():
        for name, value in values.items():
            if isinstance(value, dict):
                yield from ((f"{entity}.{name}.{part}", single) for part, single in value.items())
            else:
                yield f"{entity}.{name}", value


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
