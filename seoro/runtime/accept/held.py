"""What instances hold: structs and actors, whose event contexts start with the execution that held them first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from seoro.runtime.accept.frames import Frame, Matched
from seoro.runtime.accept.history import History, Node
from seoro.runtime.accept.world import Instance, World
from seoro.runtime.values import Actor, Struct, Value


@dataclass(eq=False)
class Held:
    """Finds what is held.

    Args:
        world: The values of the trace.
        history: The trace.
        matched: The executions of instances.
    """

    world: World
    history: History
    matched: Matched

    def first_by(self) -> dict[Struct | Actor, tuple[Instance, Frame] | None]:
        """The execution that held each struct and actor first; None if that is not told: where several began at
        once, one may not have begun, or a modifier was given it, which begins before."""
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
    """Whether one execution may as well have begun before another as after it."""
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


def _numbers(told: Any) -> Iterator[int]:
    """The numbers of what a told value is or has in it."""
    if isinstance(told, dict):
        if isinstance(told.get("object"), int):
            yield told["object"]
        for value in told.values():
            yield from _numbers(value)
    elif isinstance(told, list):
        for value in told:
            yield from _numbers(value)
