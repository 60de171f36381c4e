"""Behaviors of the plan: what a scenario does (7.3.13, 7.2.2.4.7).

`modifications` are what stands in the `with:` block of a behavior and does something to it as a whole, in the
order of the text: the one written last is closest to the behavior. A `duration` is a range in seconds for the time
from the start of the behavior to its end.

In the `constraints` of a composition, the fields of the binding `it` are its parameters: `duration`, a range; of
`parallel` also `overlap`, an enumeration, and `start_to_start` and `end_to_end`, times. In those of an invocation,
`it` has `duration` besides the fields of what is invoked, unless one of these has that name.
"""

from __future__ import annotations

from enum import Enum
from typing import TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.events import EventSpecification, OwnEvent
from seoro.lang.plan.expressions import Call, Expression
from seoro.lang.plan.modifications import Modification
from seoro.lang.plan.structures import ConstraintMember
from seoro.lang.plan.types import ValueType
from seoro.lang.source import Span


class Serial(Value):
    """Members one after another (7.3.13.1)."""

    label: str | None
    members: tuple[Behavior, ...]
    duration: Expression | None
    constraints: tuple[ConstraintMember, ...]
    modifications: tuple[Modification, ...]
    span: Span


class Overlap(Enum):
    """How the secondary members of `parallel` lie to the first one (7.3.13.2)."""

    EQUAL = "equal"
    START = "start"
    END = "end"
    INITIAL = "initial"
    FINAL = "final"
    INSIDE = "inside"
    FULL = "full"
    ANY = "any"


class Parallel(Value):
    """Members that overlap (7.3.13.2).

    Args:
        label: Its label.
        members: The first is the primary one.
        duration: From the first start to the last end.
        overlap: How the others lie to the primary one.
        is_overlap_given: Whether an argument says so.
        start_to_start: How long after the primary one the others start: a range in seconds.
        end_to_end: How long after the primary one the others end: a range in seconds.
        constraints: What else holds for its parameters.
        modifications: Of all of it.
    """

    label: str | None
    members: tuple[Behavior, ...]
    duration: Expression | None
    overlap: Overlap
    is_overlap_given: bool
    start_to_start: Expression | None
    end_to_end: Expression | None
    constraints: tuple[ConstraintMember, ...]
    modifications: tuple[Modification, ...]
    span: Span


class OneOf(Value):
    """Exactly one of the members (7.3.13.3)."""

    label: str | None
    members: tuple[Behavior, ...]
    duration: Expression | None
    constraints: tuple[ConstraintMember, ...]
    modifications: tuple[Modification, ...]
    span: Span


class Wait(Value):
    """`wait <event specification>`."""

    label: str | None
    event: EventSpecification
    span: Span


class Emit(Value):
    """`emit <event>(...)`; of the enclosing scenario's `end` and `fail`, this ends it; in a modifier, of what it
    modifies. All other arguments are defaults of the event that the instance has, which its type may have
    declared again.
    """

    label: str | None
    event: OwnEvent
    arguments: tuple[tuple[str, Expression], ...]
    span: Span


class CallMethod(Value):
    """`call <method>(...)`: the result, if there is one, is dropped."""

    label: str | None
    call: Call
    span: Span


class InvokeAction(Value):
    """An action, carried out by Python.

    Args:
        label: Its label.
        action: Its name in `Plan.actions`, qualified by its actor type: `differential_drive_robot.nav_to_pose`.
        actor: Who carries it out, if it belongs to an actor.
        arguments: Values of parameters, evaluated where the invocation stands.
        constraints: What else holds for the parameters, during this invocation.
        duration: How long it takes.
        modifications: What is done to it as a whole.
        span: Its place in the text.
        types: Static types of the arguments that may be of any type.
    """

    label: str | None
    action: str
    actor: Expression | None
    arguments: tuple[tuple[str, Expression], ...]
    constraints: tuple[ConstraintMember, ...]
    duration: Expression | None
    modifications: tuple[Modification, ...]
    span: Span
    types: tuple[tuple[str, ValueType], ...] = ()


class InvokeScenario(Value):
    """Another scenario, by its name in `Plan.scenarios`; the rest as for actions."""

    label: str | None
    scenario: str
    actor: Expression | None
    arguments: tuple[tuple[str, Expression], ...]
    constraints: tuple[ConstraintMember, ...]
    duration: Expression | None
    modifications: tuple[Modification, ...]
    span: Span


class Sample(Value):
    """`sample(<value>, <event>)`: whenever the event occurs, the variable takes the value (7.3.6.1.2)."""

    field: str
    value: Expression
    event: EventSpecification
    span: Span


Behavior: TypeAlias = Serial | Parallel | OneOf | Wait | Emit | CallMethod | InvokeAction | InvokeScenario


class On(Value):
    """`on <event specification>:`: for each occurrence, its members in their order, at once (7.6.2.5.5).

    Its event context starts with the instance that has it; the name of an `as` clause is bound in the members.
    """

    event: EventSpecification
    members: tuple[Emit | CallMethod, ...]
    span: Span
