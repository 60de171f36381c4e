"""Behaviors of the plan (7.3.13, 7.2.2.4.7).

`modifications` are the entries of the `with:` block that change a behavior as a whole, in source order: the last
one is the innermost. A `duration` is a range in seconds for the time from the start of the behavior to its end.

In the `constraints` of a composition, the fields of the binding `it` are its parameters: `duration`, a range; for
`parallel` also `overlap`, an enumeration, and `start_to_start` and `end_to_end`, times. In those of an invocation,
`it` has the fields of the invoked behavior, and an implicit `duration`.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from typing import TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.events import EventSpecification, OwnEvent
from seoro.lang.plan.expressions import Call, Expression
from seoro.lang.plan.modifications import Modification
from seoro.lang.plan.structures import ConstraintMember
from seoro.lang.plan.types import ValueType
from seoro.lang.source import Span


class Composition(Value):
    """Members with a common duration.

    Args:
        label: Its label.
        members: Its members, in source order.
        duration: Range of the time from the first start to the last end [s].
        constraints: Constraints on its parameters.
        modifications: Modifications of the whole composition.
        span: Its span.
    """

    label: str | None
    members: tuple[Behavior, ...]
    duration: Expression | None
    constraints: tuple[ConstraintMember, ...]
    modifications: tuple[Modification, ...]
    span: Span


class Serial(Composition):
    """Members one after another (7.3.13.1)."""


class OneOf(Composition):
    """Exactly one of the members (7.3.13.3)."""


class Overlap(Enum):
    """Relation of the secondary members of `parallel` to the first one (7.3.13.2)."""

    EQUAL = "equal"
    START = "start"
    END = "end"
    INITIAL = "initial"
    FINAL = "final"
    INSIDE = "inside"
    FULL = "full"
    ANY = "any"


class Parallel(Composition):
    """Members that overlap (7.3.13.2); the first is the primary one.

    Args:
        overlap: Relation of the others to the primary one.
        is_overlap_given: Whether the overlap is an argument.
        start_to_start: Range of the delay from the start of the primary one to those of the others [s].
        end_to_end: Range of the delay from the end of the primary one to those of the others [s].
    """

    overlap: Overlap
    is_overlap_given: bool
    start_to_start: Expression | None
    end_to_end: Expression | None


class Wait(Value):
    """`wait <event specification>`."""

    label: str | None
    event: EventSpecification
    span: Span


class Emit(Value):
    """`emit <event>(...)`.

    Emitting `end` or `fail` ends the enclosing scenario, or in a modifier the modified behavior. Missing arguments
    are defaults of the instance's event, which its type may have redeclared.
    """

    label: str | None
    event: OwnEvent
    arguments: tuple[tuple[str, Expression], ...]
    span: Span


class CallMethod(Value):
    """`call <method>(...)`; the result is ignored."""

    label: str | None
    call: Call
    span: Span


class Invocation(Value):
    """An invocation of an action or a scenario.

    Args:
        label: Its label.
        actor: Its actor, if any.
        arguments: Values of parameters, evaluated in the scope of the invocation.
        constraints: Constraints on the parameters during this invocation.
        duration: Range of its duration [s].
        modifications: Modifications of the whole invocation.
        span: Its span.
    """

    label: str | None
    actor: Expression | None
    arguments: tuple[tuple[str, Expression], ...]
    constraints: tuple[ConstraintMember, ...]
    duration: Expression | None
    modifications: tuple[Modification, ...]
    span: Span


class InvokeAction(Invocation):
    """An invocation of an action, which Python implements.

    Args:
        action: Its name in `Plan.actions`, qualified by its actor type: `differential_drive_robot.nav_to_pose`.
        types: Static types of the arguments that may be of any type.
    """

    action: str
    types: tuple[tuple[str, ValueType], ...] = ()


class InvokeScenario(Invocation):
    """An invocation of a scenario, by its name in `Plan.scenarios`."""

    scenario: str


class Sample(Value):
    """`sample(<value>, <event>)`: whenever the event occurs, the variable takes the value (7.3.6.1.2)."""

    field: str
    value: Expression
    event: EventSpecification
    span: Span


Behavior: TypeAlias = Serial | Parallel | OneOf | Wait | Emit | CallMethod | InvokeAction | InvokeScenario


class On(Value):
    """`on <event specification>:`: run the members, in order, in the instant of each occurrence (7.6.2.5.5).

    Its event context starts with its instance; the name of an `as` clause is bound in the members.
    """

    event: EventSpecification
    members: tuple[Emit | CallMethod, ...]
    span: Span


def behaviors_in(body: Behavior | None) -> Iterator[Behavior]:
    """Yield a behavior and its descendants in source order."""
    pending = [body] if body is not None else []
    while pending:
        behavior = pending.pop()
        yield behavior
        if isinstance(behavior, Composition):
            pending += reversed(behavior.members)


def invocations_in(body: Behavior | None) -> Iterator[InvokeAction | InvokeScenario]:
    """Yield all invocations in a behavior, in source order."""
    return (each for each in behaviors_in(body) if isinstance(each, InvokeAction | InvokeScenario))
