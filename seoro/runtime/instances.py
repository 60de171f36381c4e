"""What is invoked: running scenarios and actions, compositions with `it`, and who is invoked under a label."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING
from weakref import ref

from seoro.lang import plan as plan_
from seoro.lang.plan import (
    Action,
    Modifier,
    OwnEvent,
    Phase,
    PhaseEvent,
    Scenario,
)
from seoro.runtime.agenda import Scope
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.times import Window
from seoro.runtime.evaluate import HasFields
from seoro.runtime.events import Event
from seoro.runtime.instantiate import types_of
from seoro.runtime.values import Actor, Value

if TYPE_CHECKING:
    from seoro.runtime.place import Place


@dataclass(eq=False)
class Latest:
    """What was invoked last under a label.

    Args:
        instance: The instance; None before the first invocation.
        told: Called between rounds with the next one.
    """

    instance: Instance | None = None
    told: dict[Callable[[Instance], None], None] = field(default_factory=dict)

    def take(self, instance: Instance) -> None:
        """There is a new instance."""
        self.instance = instance
        for turn_to in tuple(self.told):
            turn_to(instance)


@dataclass(eq=False)
class _WithPhases:
    """What starts and ends.

    Args:
        path: Its position, for people.
        fields: Values of its parameters.
    """

    path: str
    fields: Fields
    windows: Mapping[str, Window] = field(default_factory=dict, kw_only=True)  # of its times

    @cached_property
    def _phases(self) -> dict[tuple[str | None, Phase], Event]:
        return {}

    def phase(self, label: str | None, phase: Phase) -> Event:
        """The channel of a predefined event: of a labelled member, or of this itself."""
        found = self._phases.get((label, phase))
        if found is None:
            name = f"{label}.{phase.value}" if label else phase.value
            found = self._phases[label, phase] = Event(f"{self.path}.{name}", ref(self), name)
        return found


@dataclass(eq=False)
class Composed(_WithPhases):
    """A composition while it is carried out, for its `with:` block; its fields are its parameters."""

    types: tuple[str, ...] = ()

    def is_heard(self, phase: Phase) -> bool:
        """Whether anyone has listened to one of its events."""
        return (None, phase) in self._phases


@dataclass(eq=False)
class Instance(_WithPhases):
    """A running scenario or action, or a modifier of one.

    Args:
        path, fields: As for all that starts and ends.
        declaration: What runs.
        bindings: What names are bound in its scope besides its fields: `actor`, and `it` in a modifier.
        around: The scenario in which a modifier is applied, which has the global parameters; None for all else.
    """

    declaration: Scenario | Action | Modifier
    bindings: Mapping[str, Value | HasFields]
    around: HasFields | None = None
    scope: Scope | None = None  # from the start of its execution

    @property
    def actor(self) -> Actor | None:
        """The actor that a scenario or an action was invoked on, if it belongs to one."""
        actor = self.bindings.get("actor")
        assert actor is None or isinstance(actor, Actor), "asked of what is invoked"
        return actor

    @cached_property
    def types(self) -> tuple[str, ...]:
        """What `plan.Methods` calls its type and what that inherits, nearest first."""
        return types_of(self.declaration)

    @property
    def reacts(self) -> bool:
        """Whether it does anything by itself, as nearly no action does."""
        declared = self.declaration
        return bool(declared.on or declared.samples)

    @cached_property
    def events(self) -> dict[str, plan_.Event]:
        """The declarations of its events, by their names."""
        return {event.name: event for event in self.declaration.events}

    @cached_property
    def _declared(self) -> dict[str, Event]:
        return {name: Event(f"{self.path}.{name}", ref(self), name) for name in self.events}

    @cached_property
    def running(self) -> dict[str, Scope]:
        """What runs at present under labels."""
        return {}

    @cached_property
    def _latest(self) -> dict[str, Latest]:
        return {}

    def latest(self, label: str) -> Latest:
        """What was invoked last under a label."""
        return self._latest.setdefault(label, Latest())

    def invoked(self, label: str) -> Instance | None:
        """What was invoked last under a label; None before the first time."""
        return self.latest(label).instance

    def declared(self, name: str) -> Event:
        """The channel of an event that it declares."""
        return self._declared[name]

    def event(self, reference: OwnEvent) -> Event:
        """The channel of an event of this scenario or action."""
        if isinstance(reference, PhaseEvent):
            return self.phase(reference.label, reference.phase)
        return self.declared(reference.name)


@dataclass(eq=False, slots=True)
class Invoked:
    """The instances of one invocation, or what stands for one composition, for what modifies it.

    Args:
        instance: The latest; what modifies the invocation sees the first before that is carried out.
        make: Makes another one, for when it is carried out again at a place.
        depth: Of the scope of the invocation in its flow.
        is_watched: Whether what modifies it has to see the next one before that is carried out.
    """

    instance: Instance | Composed
    make: Callable[[Place], Instance | Composed]
    depth: int
    is_watched: bool = False
    _is_taken: bool = False

    def renew(self, place: Place) -> None:
        """It is going to be carried out again, by another instance."""
        if self._is_taken:
            self.instance, self._is_taken = self.make(place), False

    def take(self, place: Place) -> Instance | Composed:
        """One that has not been carried out."""
        self.renew(place)
        self._is_taken = True
        return self.instance
