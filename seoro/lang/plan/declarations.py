"""Declarations of the plan: scenarios, actions, and the plan itself."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang.frozen import Value
from seoro.lang.plan.behaviors import Behavior
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.types import ActorType, ValueType
from seoro.lang.source import Span


class Parameter(Value):
    """A parameter of a scenario, which each invocation has to give if it has no value, or a global parameter."""

    name: str
    type: ValueType
    value: Expression | None
    span: Span


class Event(Value):
    """An event of a scenario, with the names of its parameters."""

    name: str
    parameters: tuple[str, ...]
    span: Span


class Scenario(Value):
    """A scenario with everything it inherits; `bases` are the names of what it inherits, nearest first."""

    name: str
    bases: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    events: tuple[Event, ...]
    body: Behavior | None
    span: Span


class ActionParameter(Value):
    """A parameter of an action's declaration."""

    name: str
    type: ValueType
    span: Span


class Action(Value):
    """The declaration of an action; `library` is what was imported to get it, such as `osc.nav2`."""

    name: str
    actor: ActorType | None
    parameters: tuple[ActionParameter, ...]
    library: str | None
    span: Span


class Plan(Value):
    """A scenario with all it reaches, ready to run.

    Args:
        entry: The scenario to run, a key of `scenarios`.
        scenarios: The entry scenario and every scenario that can be invoked from it.
        actions: Every action that can be invoked.
        globals: The global parameters, each after those that it refers to (7.3.14); evaluated once for a run.
        file: The entry file, as the user named it.
    """

    entry: str
    scenarios: Mapping[str, Scenario]
    actions: Mapping[str, Action]
    globals: tuple[Parameter, ...]
    file: str
