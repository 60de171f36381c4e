"""Results of a sweep: a table with a line per run (parameters, status, measurements), and JUnit XML."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from seoro.runtime.trace.junit import TAGS, Case, junit
from seoro.sweep.measured import measured
from seoro.sweep.running import Ran

TABLE = "results.csv"
JUNIT = "test.xml"


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
