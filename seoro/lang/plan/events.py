"""Events of the plan: references, and specifications (7.3.10)."""

from __future__ import annotations

from enum import Enum
from typing import TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.expressions import Expression
from seoro.lang.source import Span


class DeclaredEvent(Value):
    """An event of the instance of the scope."""

    name: str
    span: Span


class Phase(Enum):
    """The predefined events (7.3.10.3)."""

    START = "start"
    END = "end"
    FAIL = "fail"


def phase_name(label: str | None, phase: Phase) -> str:
    """Return the name of a predefined event of a labelled member, or of the instance itself."""
    return f"{label}.{phase.value}" if label else phase.value


class PhaseEvent(Value):
    """`start`, `end` or `fail` of a labelled member.

    Without a label, it is an event of the scenario of the scope, or in a modifier of the modified behavior.
    """

    label: str | None
    phase: Phase
    span: Span

    @property
    def name(self) -> str:
        """Name within its scenario or action: `end`, or `label.end`."""
        return phase_name(self.label, self.phase)


OwnEvent: TypeAlias = DeclaredEvent | PhaseEvent


class MemberEvent(Value):
    """An event of another object: of a struct, an actor, or, in a modifier, of the scenario that it modifies.

    Args:
        base: The object.
        event: Its event, in the scope of the object.
    """

    base: Expression
    event: OwnEvent
    span: Span


class LabelEvent(Value):
    """An event of the scenario or action that was invoked last under a label.

    Args:
        label: The label, in the scenario of the scope.
        event: The event, in the scope of the invoked behavior.
    """

    label: str
    event: EventReference
    span: Span


EventReference: TypeAlias = OwnEvent | MemberEvent | LabelEvent


class Holds(Value):
    """A boolean expression as a condition."""

    condition: Expression
    span: Span


class Rise(Value):
    """`rise(<condition>)`: it becomes true after the start of the event context."""

    condition: Expression
    span: Span


class Fall(Value):
    """`fall(<condition>)`: it becomes false after the start of the event context."""

    condition: Expression
    span: Span


class Elapsed(Value):
    """`elapsed(<duration>)`; the duration is in seconds, or a range from which one is drawn."""

    duration: Expression
    span: Span


class Every(Value):
    """`every(<period>[, offset: <offset>])`, in seconds; first after the offset, which is 0 unless it is given."""

    period: Expression
    offset: Expression | None
    span: Span


EventCondition: TypeAlias = Holds | Rise | Fall | Elapsed | Every


class OnEvent(Value):
    """`@<event> [as <name>] [if <condition>]`; the condition is evaluated when the event occurs."""

    event: EventReference
    name: str | None
    condition: EventCondition | None
    span: Span


EventSpecification: TypeAlias = OnEvent | EventCondition
