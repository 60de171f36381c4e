"""A trace as it is read: behaviors with their starts and ends, and what happened beside them."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import Any, NamedTuple

TIME_DIGITS = 9  # times are kept to the nanosecond

Record = dict[str, Any]


class Mark(NamedTuple):
    """A place in a trace: number of the record, and the time [s]."""

    seq: int
    t: float


@dataclass(eq=False)
class Attempt:
    """One time that a modifier carried out what it modifies."""

    start: Mark
    end: Mark
    status: str


@dataclass(eq=False)
class Node:
    """A behavior, or a modifier, as the trace tells it.

    Args:
        number: Its `id`.
        parent: What it is carried out in; None for the run itself.
        type: Its kind.
        name: What people call it.
        path: Its position, for people.
        source: Its place in the scenario.
        start: Its start.
        end: Its end; that of the trace, if it has none.
        status: How it ended.
        reason: Why.
        arguments: The values of a modifier's parameters, as they are told.
        children: What is carried out in it, in the order of starts.
        attempts: Of a modifier.
        instances: Numbers of what it invoked, in their order.
        told: The records that tell of these.
        cancelled: When an action was told that it is.
    """

    number: int
    parent: Node | None
    type: str
    name: str
    path: str
    source: str
    start: Mark
    end: Mark
    status: str = "cancelled"
    reason: str = ""
    arguments: Record = field(default_factory=dict)
    children: list[Node] = field(default_factory=list)
    attempts: list[Attempt] = field(default_factory=list)
    instances: list[int] = field(default_factory=list)
    told: list[int] = field(default_factory=list)
    cancelled: Mark | None = None

    @property
    def owner(self) -> Node:
        """The behavior that a modifier is part of; of a behavior, that itself."""
        node = self
        while node.type == "modifier" and node.parent is not None:
            node = node.parent
        return node

    @property
    def records(self) -> tuple[int, int]:
        """The numbers of its records."""
        return self.start.seq, self.end.seq


@dataclass(frozen=True)
class Happening:
    """An event, or a change of a variable.

    Args:
        mark: When.
        of: Number of the instance that has the event or the variable.
        name: What that calls it.
        told: The record.
    """

    mark: Mark
    of: int
    name: str
    told: Record

    @property
    def is_derived(self) -> bool:
        """Whether an event was not emitted, but what it is declared to be has occurred."""
        return bool(self.told.get("derived"))


@dataclass(eq=False)
class History:
    """All of a trace.

    Args:
        records: The records.
        run: `run.start`.
        end: `run.end`.
        root: The behavior that is the run itself.
        nodes: Behaviors by number.
        events: Events of instances, by the number of the instance and the name.
        changes: Changes of variables, likewise.
        instances: The records of instances.
        times: The instants that the trace shows [s].
    """

    records: list[Record]
    run: Record
    end: Record
    root: Node
    nodes: dict[int, Node]
    events: dict[tuple[int, str], list[Happening]]
    changes: dict[tuple[int, str], list[Happening]]
    instances: list[Record]
    times: list[float]
    cleanups: list[tuple[float, float]] = field(default_factory=list)

    @property
    def is_exact(self) -> bool:
        """Whether the runtime is the master of time and meets each moment exactly."""
        return self.run.get("clock") == "virtual"

    def reached(self, due: float) -> float:
        """When what is due at a time happens [s]: on clocks that are read, in the first instant from then on.

        It is infinite if the trace does not reach as far.
        """
        due = round(due, TIME_DIGITS)
        if self.is_exact:
            return due
        index = bisect_left(self.times, due - 0.5 * 10**-TIME_DIGITS)
        return self.times[index] if index < len(self.times) else float("inf")

    def lasts(self, since: float, until: float) -> bool:
        """Whether what is ended at one time has its end at another: in the same instant, unless actions that were
        cancelled have cleaned up meanwhile."""
        for start, end in self.cleanups:  # in the order of starts
            if start <= since < end:
                since = end
        return since >= until

    def may_be_one(self, first: int, second: int) -> bool:
        """Whether two changes, of variables or of what labels stand for, may have taken hold at once."""
        records = self.records
        if records[first]["t"] != records[second]["t"]:
            return False
        is_label = records[first]["kind"] == "instance"
        return is_label or all(record["kind"] == "variable" for record in records[first : second + 1])
