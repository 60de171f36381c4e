"""What a run is doing, as a tree that fits a screen: kept from the records of its trace.

What ended long ago is folded into its line, and of many that have ended under one behavior only the last are kept,
so that memory is bounded by what runs at one time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

ENDED_KEPT: Final = 50  # behaviors that have ended, under one
UNFOLDED: Final = 500  # behaviors that have ended whose parts are kept
MESSAGES_KEPT: Final = 50
VARIABLES_KEPT: Final = 20  # those that changed last


@dataclass(eq=False)
class Node:
    """A behavior.

    Args:
        id: Its number in the trace.
        parent: What it is part of.
        type: Its kind, as in the trace.
        name: What people call it.
        source: Its place in the scenario.
        start: When it started [s].
        end: When it ended; None while it runs.
        status: How it ended; `running` before.
        reason: Why it failed.
        children: What is or was part of it; those that run are all here.
        folded: How many more were.
    """

    id: int
    parent: Node | None
    type: str
    name: str
    source: str
    start: float
    end: float | None = None
    status: str = "running"
    reason: str = ""
    children: list[Node] = field(default_factory=list)
    folded: int = 0

    @property
    def is_waiting(self) -> bool:
        """Whether it does nothing but wait."""
        return self.end is None and self.type == "wait"


@dataclass(frozen=True)
class Row:
    """A line of the tree: a behavior, or in the place of several that have ended their number."""

    depth: int
    node: Node | None
    folded: int = 0


class Tree:
    """The state of a run."""

    def __init__(self) -> None:
        self.time = 0.0
        self.clock = ""
        self.roots: list[Node] = []
        self.messages: deque[tuple[float, str, str]] = deque(maxlen=MESSAGES_KEPT)  # time, level, text
        self.variables: dict[str, object] = {}  # those that changed last, last
        self._running: dict[int, Node] = {}
        self._unfolded: deque[Node] = deque()

    def record(self, record: dict[str, Any]) -> None:
        """Take a record."""
        self.time = record["t"]
        match record["kind"]:
            case "run.start":
                self.clock = record["clock"]
            case "behavior.start":
                self._start(record)
            case "behavior.end" if (node := self._running.pop(record["id"], None)) is not None:
                node.end, node.status, node.reason = record["t"], record["status"], record["reason"]
                self._ended(node)
            case "log":
                self.messages.append((record["t"], record["level"], str(record["message"])))
            case "variable":
                self.variables.pop(record["path"], None)
                self.variables[record["path"]] = record["value"]
                if len(self.variables) > VARIABLES_KEPT:
                    del self.variables[next(iter(self.variables))]

    def _start(self, record: dict[str, Any]) -> None:
        parent = self._running.get(record["parent"])
        node = Node(record["id"], parent, record["type"], record["name"], record["source"], record["t"])
        self._running[node.id] = node
        (parent.children if parent is not None else self.roots).append(node)

    def _ended(self, node: Node) -> None:
        """Fold what ended before, where that is much."""
        if node.parent is not None:
            _fold(node.parent)
        if node.children:
            self._unfolded.append(node)
        if len(self._unfolded) > UNFOLDED:
            oldest = self._unfolded.popleft()
            oldest.folded += len(oldest.children)
            oldest.children.clear()

    def rows(self, height: int) -> list[Row]:
        """The lines of the tree in a number of lines, at least two.

        What has ended is left out first, then what only contains others, then what started last.
        """
        for kept, is_deep in ((2 * ENDED_KEPT, True), (2 * ENDED_KEPT, False), (3, False), (1, False), (0, False)):
            rows = list(self._rows(kept, is_deep, height + 1))
            if len(rows) <= height:
                return rows
        parents = {node.parent for node in self._running.values()}
        leaves = [node for node in self._running.values() if node not in parents]
        shown = [Row(0, self.roots[0]), *(Row(1, leaf) for leaf in leaves)]
        if len(shown) <= height:
            return shown
        return [*shown[: height - 1], Row(1, None, len(shown) - height + 1)]

    def _rows(self, kept: int, is_deep: bool, most: int) -> Iterator[Row]:
        """Some of the lines.

        Args:
            kept: How many to show of what has ended last under each behavior.
            is_deep: Whether to show what is part of what has ended, and not only what failed of that.
            most: No more lines than that.
        """
        waiting = [(0, root) for root in reversed(self.roots)]
        number = 0
        while waiting and number < most:
            depth, node = waiting.pop()
            ended = [child for child in node.children if child.end is not None]
            if node.end is None or is_deep:
                shown = set(ended[-kept:] if kept else ())
            else:
                shown = {child for child in ended if child.status == "failed"}
            folded = node.folded + len(ended) - len(shown)
            yield Row(depth, node, folded)
            number += 1
            inside = [child for child in node.children if child.end is None or child in shown]
            waiting += [(depth + 1, child) for child in reversed(inside)]


def _fold(node: Node) -> None:
    """Keep no more than some of what has ended in a behavior; those that run are kept all."""
    if len(node.children) > 2 * ENDED_KEPT:
        ended = [child for child in node.children if child.end is not None]
        drop = set(ended[:-ENDED_KEPT])
        node.folded += len(drop)
        node.children = [child for child in node.children if child not in drop]
