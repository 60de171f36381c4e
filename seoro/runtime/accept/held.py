"""Objects held by instances: their event contexts start with the execution that held them first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from seoro.runtime.accept.frames import Frame, Matched
from seoro.runtime.accept.history import History, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.world import World
from seoro.runtime.values.values import Actor, Struct, Value


@dataclass(eq=False)
class Held:
    """Finds held objects.

    Args:
        world: Values of the trace.
        history: The trace.
        matched: Executions of instances.
    """

    world: World
    history: History
    matched: Matched

    def first_by(self) -> dict[Struct | Actor, tuple[Instance, Frame] | None]:
        """Executions that held each struct and actor first; None if unknown: several may have started at once, one
        may not have started, or a modifier received the object before."""
        found: dict[Struct | Actor, tuple[Instance, Frame] | None] = {}
        for instance, frame in sorted(self.matched.executions, key=lambda each: each[1].start.seq):
            has_begun = frame.start.t < frame.end.t or frame.status not in frame.cuts
            for holder in _held(list(dict(instance.fields).values())):
                first = found.setdefault(holder, (instance, frame) if has_begun else None)
                if first is not None and _are_beside(first[1], frame):
                    found[holder] = None
        for node in self.history.nodes.values():
            for number in _numbers(node.arguments):
                given = self.world.objects.get(number)
                first = found.get(given) if given is not None else None
                if given is not None and first is not None and node.start.seq < first[1].start.seq:
                    found[given] = None
        return found


def _are_beside(first: Frame, second: Frame) -> bool:
    """Whether either execution may have started first."""
    if first.start.t != second.start.t or first.end.seq < second.start.seq:
        return False
    node: Node | None = second.node
    while node is not None and node is not first.node:
        node = node.parent
    return node is None


def _held(values: list[Value]) -> Iterator[Struct | Actor]:
    seen: set[int] = set()
    while values:
        value = values.pop()
        if isinstance(value, tuple):
            values += value
        elif isinstance(value, Struct | Actor) and id(value) not in seen:
            seen.add(id(value))
            yield value
            values += dict(value.fields).values()


def _numbers(recorded: Any) -> Iterator[int]:
    """Yield the numbers of instances in an encoded value."""
    if isinstance(recorded, dict):
        if isinstance(recorded.get("object"), int):
            yield recorded["object"]
        for value in recorded.values():
            yield from _numbers(value)
    elif isinstance(recorded, list):
        for value in recorded:
            yield from _numbers(value)
