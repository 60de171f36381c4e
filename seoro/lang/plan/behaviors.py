"""Behaviors of the plan: what a scenario does (7.3.13, 7.2.2.4.7)."""

from __future__ import annotations

from typing import TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.events import EventReference, EventSpecification
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.structures import ConstraintMember
from seoro.lang.source import Span


class Serial(Value):
    """Members one after another (7.3.13.1)."""

    label: str | None
    members: tuple[Behavior, ...]
    span: Span


class Parallel(Value):
    """Members that start together; it ends when all have ended (7.3.13.2, overlap: start)."""

    label: str | None
    members: tuple[Behavior, ...]
    span: Span


class OneOf(Value):
    """Exactly one of the members (7.3.13.3)."""

    label: str | None
    members: tuple[Behavior, ...]
    span: Span


class Wait(Value):
    """`wait <event specification>`."""

    label: str | None
    event: EventSpecification
    span: Span


class Emit(Value):
    """`emit <event>(...)`; of the enclosing scenario's `end` and `fail`, this ends it."""

    label: str | None
    event: EventReference
    arguments: tuple[tuple[str, Expression], ...]
    span: Span


class InvokeAction(Value):
    """An action, carried out by Python.

    Args:
        label: Its label.
        action: Its name in `Plan.actions`, qualified by its actor type: `differential_drive_robot.nav_to_pose`.
        actor: Who carries it out, if it belongs to an actor.
        arguments: Values of parameters, evaluated where the invocation stands.
        constraints: What else holds for the parameters, during this invocation.
        span: Its place in the text.
    """

    label: str | None
    action: str
    actor: Expression | None
    arguments: tuple[tuple[str, Expression], ...]
    constraints: tuple[ConstraintMember, ...]
    span: Span


class InvokeScenario(Value):
    """Another scenario, by its name in `Plan.scenarios`; the rest as for actions."""

    label: str | None
    scenario: str
    actor: Expression | None
    arguments: tuple[tuple[str, Expression], ...]
    constraints: tuple[ConstraintMember, ...]
    span: Span


Behavior: TypeAlias = Serial | Parallel | OneOf | Wait | Emit | InvokeAction | InvokeScenario
