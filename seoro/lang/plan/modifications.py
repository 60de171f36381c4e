"""Modifications of a behavior as a whole: `until`, and modifiers (7.2.2.4.7, 7.3.12)."""

from __future__ import annotations

from enum import Enum
from typing import TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.events import EventSpecification
from seoro.lang.plan.expressions import Expression
from seoro.lang.source import Span


class Until(Value):
    """`until <event specification>`: the behavior ends when the event occurs, and not before (7.6.2.5.4).

    In the `with:` block of an invocation, the binding `it` is the invoked instance.
    """

    event: EventSpecification
    span: Span


class ModifierApplication(Value):
    """`[<actor>.]<modifier>(<arguments>)` (7.3.12.4).

    Args:
        modifier: Its name in `Plan.modifiers`.
        actor: The actor that it is applied to, if the modifier belongs to one.
        arguments: Arguments; other parameters have the values of the modifier. In the `with:` block of an
            invocation, the binding `it` is the invoked instance.
        ranges: Ranges for parameters that hold one number (7.3.12.4.1).
        span: Its span.
    """

    modifier: str
    actor: Expression | None
    arguments: tuple[tuple[str, Expression], ...]
    ranges: tuple[tuple[str, Expression], ...]
    span: Span


class OverrideMode(Enum):
    """Mode of `override` (7.3.12.1.1)."""

    ON_START = "on_start"
    WHEN_ACTIVE = "when_active"


LabelPath: TypeAlias = tuple[str, ...]  # a label, then one of the invoked behavior, and so on


class Override(Value):
    """`override(<overridden>, <by>[, <mode>])` (7.3.12.1.1): the first ends when the second starts.

    Labels belong to the enclosing scenario. With `when_active`, the first also does not start while the second
    runs.
    """

    overridden: LabelPath
    by: LabelPath
    mode: OverrideMode
    span: Span


AppliedModifier: TypeAlias = ModifierApplication | Override
Modification: TypeAlias = Until | AppliedModifier
