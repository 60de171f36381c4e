"""Instances: running scenarios and actions, compositions with `it`, and the latest invocation of each label.

An instance holds the structs and actors in its fields, and in the fields of these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableSet
from dataclasses import field
from functools import cached_property

from seoro.deferred import dataclass
from seoro.lang import plan as plan_
from seoro.runtime.instances.times import Window
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.channel import Channel
from seoro.runtime.values.values import Actor, Fields, HasFields, Struct, Value


@dataclass(eq=False)
class Latest:
    """Latest invocation under a label.

    Args:
        instance: The instance; None before the first invocation.
        on_change: Called between delta cycles with the next one.
    """

    instance: Instance | None = None
    on_change: dict[Callable[[Instance], None], None] = field(default_factory=dict)

    def set(self, instance: Instance) -> None:
        """Set a new instance."""
        self.instance = instance
        for act in tuple(self.on_change):
            act(instance)


@dataclass(eq=False)
class _WithPhases:
    """Base of instances with `start` and `end` events.

    Args:
        path: Its position, as text.
        fields: Values of its parameters.
    """

    path: str
    fields: Fields
    windows: Mapping[str, Window] = field(default_factory=dict, kw_only=True)  # of its timing parameters

    @cached_property
    def channels(self) -> dict[str, Channel]:
        """Channels of its events that were used so far, by name; those of labels as `label.end`."""
        return {}

    def event_path(self, event: plan_.OwnEvent) -> str:
        """Return the full name of one of its events."""
        return f"{self.path}.{event.name}"


@dataclass(eq=False)
class Composed(_WithPhases):
    """A running composition with a `with:` block; its fields are its parameters."""

    types: tuple[str, ...] = ()

    def has_channel(self, phase: plan_.Phase) -> bool:
        """Whether one of its events has ever had a subscriber."""
        return phase.value in self.channels


@dataclass(eq=False)
class Instance(_WithPhases):
    """A running scenario or action, or a modifier of one.

    Args:
        path, fields: See the base class.
        declaration: Declaration of the scenario, action or modifier.
        bindings: Bindings in its scope besides its fields: `actor`, and `it` in a modifier.
        around: For a modifier, the surrounding scenario with the global parameters; otherwise None.
    """

    declaration: plan_.Scenario | plan_.Action | plan_.Modifier
    bindings: Mapping[str, Value | HasFields]
    around: HasFields | None = None
    scope: CancelScope | None = None  # set when it starts

    @property
    def actor(self) -> Actor | None:
        """Actor of the invocation, or None."""
        actor = self.bindings.get("actor")
        assert actor is None or isinstance(actor, Actor), "not a modifier"
        return actor

    @cached_property
    def types(self) -> tuple[str, ...]:
        """Names of its type and the inherited ones as in `plan.Methods`, nearest first."""
        return types_of(self.declaration)

    @property
    def reacts(self) -> bool:
        """Whether it has reactions of its own; nearly no action has."""
        declared = self.declaration
        return bool(declared.on or declared.samples)

    @cached_property
    def events(self) -> dict[str, plan_.Event]:
        """Declarations of its events by name."""
        return {event.name: event for event in self.declaration.events}

    @cached_property
    def running(self) -> dict[str, CancelScope]:
        """Scopes of running behaviors by label."""
        return {}

    @cached_property
    def _latest(self) -> dict[str, Latest]:
        return {}

    def latest(self, label: str) -> Latest:
        """Return the latest invocation under a label."""
        return self._latest.setdefault(label, Latest())

    def invoked(self, label: str) -> Instance | None:
        """Return the latest instance under a label; None before the first one."""
        return self.latest(label).instance


def types_of(declared: plan_.Scenario | plan_.Action | plan_.Modifier) -> tuple[str, ...]:
    """Return the type names of a declaration as in `plan.Methods`, including inherited ones, nearest first."""
    if isinstance(declared, plan_.Modifier):
        return (plan_.modifier_type(declared.name),)
    return (plan_.behavior_type(declared.name), *map(plan_.behavior_type, declared.bases))


def newly_held(instance: HasFields, seen: MutableSet[Struct | Actor]) -> Iterator[tuple[Struct | Actor, str]]:
    """Yield the objects that an instance is the first to hold, with their paths.

    Args:
        instance: The instance.
        seen: Objects held before; found ones are added.
    """
    pending: list[tuple[str, Value]] = list(instance.fields.items())
    while pending:
        path, value = pending.pop(0)
        if isinstance(value, tuple):
            pending[:0] = [(f"{path}[{number}]", part) for number, part in enumerate(value)]
        elif isinstance(value, Struct | Actor) and value not in seen:
            seen.add(value)
            yield value, path
            pending[:0] = [(f"{path}.{name}", part) for name, part in value.fields.items()]
