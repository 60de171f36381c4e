"""Tree of the behaviors of a run, built from the records of its trace, small enough for a screen.

Old ended behaviors are folded into the line of their parent, and each parent keeps only the latest ended children.
So memory is bounded by the number of running behaviors.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

ENDED_KEPT: Final = 50  # ended children of a behavior
UNFOLDED: Final = 500  # ended behaviors that keep their children
MESSAGES_KEPT: Final = 50
VARIABLES_KEPT: Final = 20  # latest changes


@dataclass(eq=False)
class Node:
    """A behavior.

    Args:
        id: Number in the trace.
        parent: Enclosing behavior.
        type: Type, as in the trace.
        name: Name for people.
        source: Location in the scenario.
        start: Time of the start [s].
        end: Time of the end [s]; None while it runs.
        status: Status at the end; `running` before.
        reason: Reason of a failure.
        children: All running and the latest ended children.
        folded: Number of other ended children.
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


@dataclass(frozen=True)
class Row:
    """Line of the tree: a behavior, or a number of hidden behaviors."""

    depth: int
    node: Node | None
    folded: int = 0


class Tree:
    """State of a run."""

    def __init__(self) -> None:
        self.time = 0.0
        self.clock = ""
        self.roots: list[Node] = []
        self.messages: deque[tuple[float, str, str]] = deque(maxlen=MESSAGES_KEPT)  # time, level, text
        self.variables: dict[str, object] = {}  # in order of the latest changes
        self._running: dict[int, Node] = {}
        self._unfolded: deque[Node] = deque()

    def record(self, record: dict[str, Any]) -> None:
        """Update the tree with a record."""
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
        """Fold old ended behaviors."""
        if node.parent is not None:
            _fold(node.parent)
        if node.children:
            self._unfolded.append(node)
        if len(self._unfolded) > UNFOLDED:
            oldest = self._unfolded.popleft()
            oldest.folded += len(oldest.children)
            oldest.children.clear()

    def rows(self, height: int) -> list[Row]:
        """Return at most `height` (at least two) lines of the tree.

        Ended behaviors are dropped first, then composite ones, then the latest started.
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
        """Yield lines of the tree.

        Args:
            kept: Number of the latest ended children to show per behavior.
            is_deep: Whether to show all children of ended behaviors, instead of failed ones only.
            most: Maximum number of lines.
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
    """Drop old ended children of a behavior; keep all running ones."""
    if len(node.children) > 2 * ENDED_KEPT:
        ended = [child for child in node.children if child.end is not None]
        drop = set(ended[:-ENDED_KEPT])
        node.folded += len(drop)
        node.children = [child for child in node.children if child not in drop]
