"""Planned runs of a campaign, and rows for runs that have ended."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from enum import Enum
from typing import Any, Final, TypeVar

from pydantic_core import from_json

from seoro.campaign.numbers import Numbers
from seoro.lang.frozen import Value
from seoro.runtime.trace.jsonl import to_json
from seoro.runtime.verdict import RunStatus


class Point(Value):
    """Values that a strategy asks for.

    Args:
        values: Values of parameters by path, in the notation of the scenario; the solver draws all others.
        reason: Reason, such as a bucket that lacks samples; may be empty.
        parent: Number of the run that it was derived from; 0 without one.
    """

    values: Mapping[str, str]
    reason: str = ""
    parent: int = 0


class Planned(Value):
    """Planned run.

    Args:
        number: Number in the campaign, from 1.
        variant: Number of its point, from 1; repeats of a point share it.
        repeat: Number among the repeats of its point, from 1.
        seed: Random seed.
        values: Values of parameters by path, in the notation of the scenario.
        strategy: Strategy that asked for it, with its reason.
        parent: Number of the run that it was derived from; 0 without one.
        attempt: Number of the attempt, from 1. A run whose worker died is tried again.
    """

    number: int
    variant: int
    repeat: int
    seed: int
    values: Mapping[str, str]
    strategy: str
    parent: int = 0
    attempt: int = 1

    def to_line(self) -> str:
        """Encode for `asked.jsonl`, and for workers."""
        return to_json(_plain(self)) + "\n"

    @staticmethod
    def from_line(line: bytes | str) -> Planned:
        """Decode what `to_line` made.

        Raises:
            ValueError: The line is not such a line.
        """
        return _made(Planned, _decoded(line, Planned))


def title_of(values: Mapping[str, str]) -> str:
    """Describe values, for people."""
    return " ".join(f"{path}={value}" for path, value in values.items()) or "without variation"


class End(Enum):
    """Ends of runs of a campaign: the statuses of verdicts, and one for runs that never begin."""

    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"
    CANCELLED = "cancelled"
    IMPOSSIBLE = "impossible"  # constraints exclude its values; no run, and in no table

    @staticmethod
    def of(status: RunStatus) -> End:
        """Return the end with a verdict."""
        return End(status.value)


class Row(Value):
    """End of a run, a row of `runs.csv`.

    Args:
        run: Number in the campaign.
        id: Identity of the run: equal ids promise equal runs.
        variant, repeat, seed, strategy, parent, attempt: As planned.
        status: Its end.
        values: Values of the parameters that vary, by path, in SI base units.
        duration: Duration on the run's clock [s].
        wall_duration: Duration on the machine's clock [s].
        cpu: Processor time of the worker [s].
        sim_cpu: Processor time of its simulator [s].
        reason: Reason of the verdict.
        reason_key: Reason without numbers and names of instances, to group failures by.
        where: Place in the text that decided: `file:line:column`; empty without one.
        margin: Distance to the nearest limit, negative beyond it; None without a limit.
        host, worker: Machine and process.
        started: Time of its start (UTC, ISO 8601).
        version: Version of seoro.
        folder: Folder with its trace and its files, relative to that of the campaign; empty if not kept.
        trace_sha: SHA-256 of its trace without times of the machine; equal runs have equal ones.
        measured: Measurements: `ROBOT.NAME`, `record.ITEM`, `cover.ITEM`.
        coverage: Coverage of its items, as in `coverage.json`.
    """

    run: int
    id: str
    variant: int
    repeat: int
    seed: int
    status: End
    values: Mapping[str, Any] = field(default_factory=dict)
    duration: float = 0.0
    wall_duration: float = 0.0
    cpu: float = 0.0
    sim_cpu: float = 0.0
    reason: str = ""
    reason_key: str = ""
    where: str = ""
    margin: float | None = None
    strategy: str = ""
    parent: int = 0
    attempt: int = 1
    host: str = ""
    worker: str = ""
    started: str = ""
    version: str = ""
    folder: str = ""
    trace_sha: str = ""
    measured: Mapping[str, Any] = field(default_factory=dict)
    coverage: tuple[Mapping[str, Any], ...] = ()

    def to_line(self) -> str:
        """Encode for a shard."""
        return to_json(_plain(self) | {"status": self.status.value}) + "\n"

    def _repr_html_(self) -> str:
        """Return the run for notebooks."""
        from seoro.campaign.results.html import row_html  # noqa: PLC0415 - it needs this module

        return row_html(self)

    @staticmethod
    def from_line(line: bytes | str) -> Row:
        """Decode what `to_line` made.

        Raises:
            ValueError: The line is not such a line.
        """
        given = _decoded(line, Row)
        given["status"] = End(given["status"])
        given["coverage"] = tuple(given.get("coverage", ()))
        return _made(Row, given)


def each_once(rows: Iterable[Row]) -> Iterator[Row]:
    """Return the first row of each run; a run has several if its worker died after it had written one."""
    seen = Numbers()
    return (row for row in rows if seen.add(row.run))


OF_THE_MACHINE: Final = frozenset(
    {"wall_duration", "cpu", "sim_cpu", "host", "worker", "started", "attempt", "folder"}
)
"""Columns that differ between equal runs."""


def _plain(value: Planned | Row) -> dict[str, Any]:
    return {each: getattr(value, each) for each in value.__match_args__}


_NEEDED: Final = frozenset({"seed", "variant", "repeat"})
_Line = TypeVar("_Line", Planned, Row)


def _made(kind: type[_Line], given: dict[str, Any]) -> _Line:
    if tuple(given) == kind.__match_args__:  # positional arguments need a third of the time
        return kind(*given.values())
    return kind(**given)


def _decoded(line: bytes | str, kind: type[Planned | Row]) -> dict[str, Any]:
    try:
        given = from_json(line)  # in less than half of the time of the standard library
    except ValueError:
        given = json.loads(line)  # also halves of surrogate pairs, from names of files
    if not isinstance(given, dict):
        raise ValueError("expected an object")
    if tuple(given) == kind.__match_args__:
        return given
    if not given.keys() >= _NEEDED or not given.keys() <= set(kind.__match_args__):
        raise ValueError(f"expected the fields of a {kind.__name__}")
    return given
