"""Events of the plan: what is referred to, and what is waited for (7.3.10)."""

from __future__ import annotations

from enum import Enum
from typing import TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.expressions import Expression
from seoro.lang.source import Span


class DeclaredEvent(Value):
    """An event of the scenario in which the expression stands."""

    name: str
    span: Span


class Phase(Enum):
    """The predefined events (7.3.10.3)."""

    START = "start"
    END = "end"
    FAIL = "fail"


class PhaseEvent(Value):
    """`start`, `end` or `fail`: of a labelled member, or of the enclosing scenario without a label."""

    label: str | None
    phase: Phase
    span: Span


EventReference: TypeAlias = DeclaredEvent | PhaseEvent


class Elapsed(Value):
    """`elapsed(<duration>)`; the duration is in seconds, or a range from which one is drawn."""

    duration: Expression
    span: Span


class OnEvent(Value):
    """`@<event> [as <name>] [if <condition>]`."""

    event: EventReference
    name: str | None
    condition: Expression | None
    span: Span


EventSpecification: TypeAlias = OnEvent | Elapsed
