"""Declarations of the plan: scenarios, actions, modifiers, and the plan itself."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang.frozen import Value
from seoro.lang.plan.behaviors import Behavior, On, Sample
from seoro.lang.plan.coverage import Coverage
from seoro.lang.plan.events import EventSpecification
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.modifications import AppliedModifier
from seoro.lang.plan.structures import Constraint, Structure, Structures
from seoro.lang.plan.types import ActorType
from seoro.lang.source import Span


class Event(Value):
    """An event of an instance.

    Args:
        name: Its name.
        parameters: The names of its parameters, with their defaults, evaluated by each emission that does not give
            a value (7.3.10.2).
        specification: What makes it occur besides being emitted, in the scope of the instance that has the event;
            its event context starts where the event is used (7.3.10.4).
    """

    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    specification: EventSpecification | None
    span: Span

    def all_arguments(self, given: tuple[tuple[str, Expression], ...]) -> dict[str, Expression]:
        """An expression for each parameter, when some are given."""
        arguments = {name: default for name, default in self.parameters if default is not None}
        return {**arguments, **dict(given)}


class ObjectType(Value):
    """A struct or an actor, for what its values have besides their structure; with everything it inherits."""

    name: str
    events: tuple[Event, ...]
    samples: tuple[Sample, ...]
    modifiers: tuple[AppliedModifier, ...]
    span: Span


class Scenario(Value):
    """A scenario with everything it inherits; `bases` are the names of what it inherits, nearest first.

    `modifiers` apply to each of its invocations.
    """

    name: str
    bases: tuple[str, ...]
    structure: Structure
    events: tuple[Event, ...]
    on: tuple[On, ...]
    samples: tuple[Sample, ...]
    modifiers: tuple[AppliedModifier, ...]
    body: Behavior | None
    span: Span


class Action(Value):
    """The declaration of an action; `library` is what was imported to get it, such as `osc.nav2`, `bases` are the
    names of what it inherits, nearest first."""

    name: str
    bases: tuple[str, ...]
    actor: ActorType | None
    structure: Structure
    events: tuple[Event, ...]
    on: tuple[On, ...]
    samples: tuple[Sample, ...]
    modifiers: tuple[AppliedModifier, ...]
    library: str | None
    span: Span


class Modifier(Value):
    """The declaration of a modifier (7.3.12).

    In its expressions and constraints, the binding `actor` is the actor that it is applied to, and `it` what it
    modifies.

    Args:
        name: Its name.
        actor: The type of actor that it belongs to.
        of: The scenario or action whose invocations it modifies; None for any behavior.
        structure: Its parameters, and the constraints on them and on what it modifies.
        events: Its events.
        on: What it does on events, while what it modifies runs.
        samples: Its variables that are sampled.
        modifiers: The modifiers that it applies to what it modifies.
        library: What was imported to get it, if it is atomic: its implementation is not written in the language.
            None for a compound one.
        span: Its name in the text.
    """

    name: str
    actor: ActorType | None
    of: str | None
    structure: Structure
    events: tuple[Event, ...]
    on: tuple[On, ...]
    samples: tuple[Sample, ...]
    modifiers: tuple[AppliedModifier, ...]
    library: str | None
    span: Span


class Plan(Value):
    """A scenario with all it reaches, ready to run.

    Args:
        entry: The scenario to run, a key of `scenarios`.
        overrides: What was set from outside for its fields, and for global parameters; applied last.
        scenarios: The entry scenario and every scenario that can be invoked from it.
        actions: Every action that can be invoked.
        modifiers: Every modifier that is applied.
        objects: The structs and actors that have events, sampled variables or modifiers, by their names.
        globals: The global parameters (7.3.14), whose values are chosen with those of the entry scenario.
        structures: The structures of all structs and actors.
        file: The entry file, as the user named it.
        coverage: What is sampled, by the type that declares it (7.5).
    """

    entry: str
    overrides: tuple[Constraint, ...]
    scenarios: Mapping[str, Scenario]
    actions: Mapping[str, Action]
    modifiers: Mapping[str, Modifier]
    objects: Mapping[str, ObjectType]
    globals: Structure
    structures: Structures
    file: str
    coverage: Coverage
