"""Instances that run in frames, environments of their modifications, and reactions.

Reactions of modifiers (7.6.2.5.5) may end the modified behavior.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, takewhile
from typing import Final

from seoro.lang.plan import Emit, Modifier, Override, Phase, PhaseEvent
from seoro.runtime.accept.findings import Findings, Rule
from seoro.runtime.accept.frames import CANCELLED, FAILED, SUCCEEDED, Frame, is_ending, is_of
from seoro.runtime.accept.history import History, Node
from seoro.runtime.accept.instances import Instance
from seoro.runtime.accept.world import World
from seoro.runtime.values.environment import Environment


def running_instance(frame: Frame, world: World) -> Instance | None:
    """Return the instance that runs in a frame: a new one, or the first, made before the modifiers begin."""
    owner = frame.owner
    position = bisect(owner.recorded, frame.start.seq)
    is_inside = position < len(owner.recorded) and owner.recorded[position] < frame.end.seq
    number = owner.instances[position if is_inside else max(position - 1, 0)] if owner.instances else -1
    return world.instances.get(number)


def environment_in(frame: Frame, world: World) -> Environment:
    """Return the environment of modifications of a behavior, with the running instance as `it`."""
    environment = frame.around.environment
    instance = running_instance(frame, world)
    if instance is None:
        return environment
    return environment.bind(it=instance)


def override_scope(override: Override, frame: Frame, world: World) -> Instance:
    """Return the scenario instance whose labels an override names."""
    instance = running_instance(frame, world)
    if instance is not None and any(each is override for each in instance.declaration.modifiers):
        return instance
    return frame.around


_STATUSES: Final = {Phase.END: SUCCEEDED, Phase.FAIL: FAILED}  # by the emitted event


@dataclass(eq=False)
class Reactions:
    """Reactions of a modifier.

    Args:
        modifier: The modifier.
        node: Its behavior in the trace.
        history: The trace.
    """

    modifier: Modifier
    node: Node
    history: History

    def __post_init__(self) -> None:
        members = [member for directive in self.modifier.on for member in directive.members]
        self.nodes = [child for child in self.node.children if any(is_of(child, each) for each in members)]
        emits = [each for each in members if isinstance(each, Emit) and is_ending(each)]
        late = [node for node in self.nodes if self.history.lasts(node.start.t, self.node.end.t)]
        self.endings = [(node, emit) for node in late for emit in emits if is_of(node, emit)]  # of the behavior

    def check_end(self, frame: Frame, findings: Findings) -> None:
        """Check the end of a modifier that ends itself, unless the modified behavior ended in that instant too."""
        statuses = {_STATUSES[emit.event.phase] for _, emit in self.endings if isinstance(emit.event, PhaseEvent)}
        ended = {child.status for child in frame.children if child.end.t == frame.end.t}
        if frame.status not in statuses | ended | {CANCELLED}:
            node, emit = self.endings[0]
            message = f"`{self.modifier.name}` {frame.status}, but its own `emit` ends it otherwise"
            findings.violate(Rule.EMIT, message, emit.span, node.start.seq, frame.end.seq)


def late_reactions(instance: Instance, frame: Frame) -> Iterator[Node]:
    """Yield the reactions of an instance to its own end, in the same instant."""
    nodes, path = frame.node.children, f"{instance.recorded.get('path')}/on["
    first = bisect(nodes, frame.end.seq, key=lambda node: node.start.seq)
    then = takewhile(lambda node: node.start.t == frame.end.t, islice(nodes, first, None))
    return (node for node in then if node.path.startswith(path))
