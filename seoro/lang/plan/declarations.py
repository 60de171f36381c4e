"""Declarations of the plan: scenarios, actions, and the plan itself."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang.frozen import Value
from seoro.lang.plan.behaviors import Behavior
from seoro.lang.plan.coverage import Coverage
from seoro.lang.plan.structures import Constraint, Structure, Structures
from seoro.lang.plan.types import ActorType
from seoro.lang.source import Span


class Event(Value):
    """An event of a scenario, with the names of its parameters."""

    name: str
    parameters: tuple[str, ...]
    span: Span


class Scenario(Value):
    """A scenario with everything it inherits; `bases` are the names of what it inherits, nearest first."""

    name: str
    bases: tuple[str, ...]
    structure: Structure
    events: tuple[Event, ...]
    body: Behavior | None
    span: Span


class Action(Value):
    """The declaration of an action; `library` is what was imported to get it, such as `osc.nav2`, `bases` are the
    names of what it inherits, nearest first."""

    name: str
    bases: tuple[str, ...]
    actor: ActorType | None
    structure: Structure
    library: str | None
    span: Span


class Plan(Value):
    """A scenario with all it reaches, ready to run.

    Args:
        entry: The scenario to run, a key of `scenarios`.
        overrides: What was set from outside for its fields, and for global parameters; applied last.
        scenarios: The entry scenario and every scenario that can be invoked from it.
        actions: Every action that can be invoked.
        globals: The global parameters (7.3.14), whose values are chosen with those of the entry scenario.
        structures: The structures of all structs and actors.
        file: The entry file, as the user named it.
        coverage: What is sampled, by the type that declares it (7.5).
    """

    entry: str
    overrides: tuple[Constraint, ...]
    scenarios: Mapping[str, Scenario]
    actions: Mapping[str, Action]
    globals: Structure
    structures: Structures
    file: str
    coverage: Coverage
