"""A trace in memory: behaviors with their starts and ends, events and changes of variables."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import Any, NamedTuple

TIME_DIGITS = 9  # nanoseconds

Record = dict[str, Any]


class Mark(NamedTuple):
    """A place in a trace: index of the record, and time [s]."""

    seq: int
    t: float


@dataclass(eq=False)
class Attempt:
    """One run of a modified behavior."""

    start: Mark
    end: Mark
    status: str


@dataclass(eq=False)
class Node:
    """A behavior or a modifier in the trace.

    Args:
        number: Its `id`.
        parent: Behavior around it; None for the run itself.
        type: Its kind.
        name: Its name.
        path: Its position, as text.
        source: Its place in the scenario.
        start: Its start.
        end: Its end; the end of the trace if missing.
        status: Its end state.
        reason: Reason of the end state.
        arguments: Encoded values of a modifier's parameters.
        children: Contained behaviors, in order of starts.
        attempts: Attempts of a modifier.
        instances: Numbers of the instances that it invoked, in order.
        recorded: Records of these instances.
        cancelled: Delivery of a cancellation to an action.
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
    recorded: list[int] = field(default_factory=list)
    cancelled: Mark | None = None

    @property
    def owner(self) -> Node:
        """The modified behavior of a modifier; otherwise the behavior itself."""
        node = self
        while node.type == "modifier" and node.parent is not None:
            node = node.parent
        return node

    @property
    def records(self) -> tuple[int, int]:
        """Indices of its records."""
        return self.start.seq, self.end.seq


@dataclass(frozen=True)
class LoggedEvent:
    """An event, or a change of a variable.

    Args:
        mark: Its place in the trace.
        of: Number of the instance that has the event or the variable.
        name: Its name in the instance.
        recorded: The record.
    """

    mark: Mark
    of: int
    name: str
    recorded: Record

    @property
    def is_derived(self) -> bool:
        """Whether an event occurred through its source, without an `emit`."""
        return bool(self.recorded.get("derived"))


@dataclass(eq=False)
class History:
    """A whole trace.

    Args:
        run: `run.start`.
        end: `run.end`.
        root: Root behavior of the run.
        records: The records.
        nodes: Behaviors by number.
        events: Events of instances, by number of the instance and name.
        changes: Changes of variables, by number of the instance and name.
        instances: Records of instances.
        times: Instants of the trace [s].
        cleanups: Starts and ends of clean-ups of cancelled actions [s].
    """

    run: Record = field(init=False)
    end: Record = field(init=False)
    root: Node = field(init=False)
    records: list[Record] = field(default_factory=list)
    nodes: dict[int, Node] = field(default_factory=dict)
    events: dict[tuple[int, str], list[LoggedEvent]] = field(default_factory=dict)
    changes: dict[tuple[int, str], list[LoggedEvent]] = field(default_factory=dict)
    instances: list[Record] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    cleanups: list[tuple[float, float]] = field(default_factory=list)

    @property
    def is_exact(self) -> bool:
        """Whether instants are exactly at due times, as on deterministic clocks."""
        return self.run.get("clock") == "virtual"

    def reached(self, due: float) -> float:
        """Return the time at which a due event happens [s]: on real clocks, in the first instant from then on.

        Infinite if the trace ends before.
        """
        due = round(due, TIME_DIGITS)
        if self.is_exact:
            return due
        index = bisect_left(self.times, due - 0.5 * 10**-TIME_DIGITS)
        return self.times[index] if index < len(self.times) else float("inf")

    def lasts(self, since: float, until: float) -> bool:
        """Whether a cancellation can complete at a later time: after clean-ups of cancelled actions."""
        for start, end in self.cleanups:  # ordered by starts
            if start <= since < end:
                since = end
        return since >= until

    def may_be_one(self, first: int, second: int) -> bool:
        """Whether two changes, of variables or labels, may have been committed together."""
        records = self.records
        if records[first]["t"] != records[second]["t"]:
            return False
        is_label = records[first]["kind"] == "instance"
        return is_label or all(record["kind"] == "variable" for record in records[first : second + 1])
