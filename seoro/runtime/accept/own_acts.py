"""What a modifier does by itself (7.6.2.5.5), which may end what it modifies; what an instance does at its end."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, takewhile
from typing import Final

from seoro.lang.plan import Emit, Modifier, Phase, PhaseEvent
from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Frame, is_ending, is_of
from seoro.runtime.accept.history import History, Node
from seoro.runtime.accept.world import Instance

_STATUSES: Final = {Phase.END: SUCCEEDED, Phase.FAIL: FAILED}  # that `emit` of these gives


@dataclass(eq=False)
class Reactions:
    """What a modifier does by itself.

    Args:
        modifier: The modifier.
        node: Where it is carried out.
    """

    modifier: Modifier
    node: Node

    def __post_init__(self) -> None:
        members = [member for directive in self.modifier.on for member in directive.members]
        self.nodes = [child for child in self.node.children if any(is_of(child, each) for each in members)]
        self._ends = [each for each in members if isinstance(each, Emit) and is_ending(each)]

    def end_it(self, history: History) -> bool:
        """Whether it ends what it modifies."""
        return any(True for _ in self._endings(history))

    def _endings(self, history: History) -> Iterator[tuple[Node, Emit]]:
        for node in self.nodes:
            if history.lasts(node.start.t, self.node.end.t):
                yield from ((node, emit) for emit in self._ends if is_of(node, emit))

    def check_end(self, frame: Frame, history: History, findings: Findings) -> None:
        """What ends itself ends so, unless what it modifies has ended in that instant, too."""
        endings = list(self._endings(history))
        statuses = {_STATUSES[emit.event.phase] for _, emit in endings if isinstance(emit.event, PhaseEvent)}
        ended = {child.status for child in frame.children if child.end.t == frame.end.t}
        if frame.status not in statuses | ended | {CANCELLED}:
            [(node, emit), *_] = endings
            message = f"`{self.modifier.name}` {frame.status}, and ends itself otherwise"
            findings.violate(Rule.EMIT, message, emit.span, node.start.seq, frame.end.seq)


def late_reactions(instance: Instance, frame: Frame) -> Iterator[Node]:
    """What an instance does at its end, after it, in the same instant."""
    nodes, path = frame.node.children, f"{instance.told.get('path')}/on["
    first = bisect(nodes, frame.end.seq, key=lambda node: node.start.seq)
    then = takewhile(lambda node: node.start.t == frame.end.t, islice(nodes, first, None))
    return (node for node in then if node.path.startswith(path))
