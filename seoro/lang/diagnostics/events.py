"""Messages of events and of the directives that emit and await them (E0408 to E0412, E0450 to E0457)."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.source import Span


class UnknownEvent(TemplateMessage):
    """An undeclared event.

    Args:
        owner: Owner that lacks the event; empty for the surrounding scope.
        is_phase: Whether the name is that of an event of scenarios.
        is_label: Whether the name is that of a label.
    """

    CODE = "E0408"
    TEXT = ("`{owner}` has no event `{name}`", "unknown event `{name}`")
    HELP = (
        "{is_label:if}`{name}` is a label: write `@{name}.end` or `@{name}.start`",
        "{is_phase:if}`start`, `end` and `fail` are events of scenarios, actions and labels",
        "{near}",
        "{owner:if}its events are {candidates:and}",
        "{owner:if}it has no events",
    )

    name: str
    candidates: tuple[str, ...]
    owner: str = ""
    is_phase: bool = False
    is_label: bool = False


class UnknownLabel(TemplateMessage):
    """A label that no behavior of the scenario has."""

    CODE = "E0409"
    TEXT = "unknown label or field `{name}`"
    HELP = "{near}"

    name: str
    candidates: tuple[str, ...]


class UnknownPhase(TemplateMessage):
    """An unknown event of a label."""

    CODE = "E0410"
    TEXT = "`{label}` has no event `{name}`"
    HELP = "a label has `start`, `end` and `fail`"

    label: str
    name: str


class EmitStart(TemplateMessage):
    """`emit start`."""

    CODE = "E0411"
    TEXT = "`start` cannot be emitted"
    HELP = "`start` occurs when a scenario starts; `emit end` and `emit fail` end it"


class NotAnEvent(TemplateMessage):
    """An `@` before something other than an event."""

    CODE = "E0412"
    TEXT = "expected an event after `@`"
    HELP = "events are `@event`, `@field.event`, and `start`, `end` or `fail` as in `@label.end`"


class NoEvents(TemplateMessage):
    """An event of a value that cannot have events."""

    CODE = "E0450"
    TEXT = "`{span.text}` is {found:a}, which has no events"
    HELP = "events belong to structs, actors and labelled behaviors"

    found: str


class OccurrenceHidesField(TemplateMessage):
    """An occurrence with the name of a field (7.3.10.4).

    Args:
        first: The field; None if it is implicit.
    """

    CODE = "E0451"
    TEXT = "`{name}` is already the name of a field"
    HELP = "choose another name after `as`"
    OTHERS = (("first", "the field is here"),)

    name: str
    first: Span | None


class SpecificationWithParameters(TemplateMessage):
    """An event with parameters and a specification, which cannot give them values (7.3.10.2)."""

    CODE = "E0452"
    TEXT = "`{name}` has parameters, so only `emit` can make it occur"
    HELP = "remove the parameters, or the specification after `is`"

    name: str


class PredefinedEvent(TemplateMessage):
    """The declaration of a predefined event (7.3.10.3)."""

    CODE = "E0453"
    TEXT = "every scenario, action and modifier already has the event `{name}`"
    HELP = "choose another name"

    name: str


class MissingAt(TemplateMessage):
    """The path of an event in the place of a condition."""

    CODE = "E0455"
    TEXT = "`{path}` is an event, not a condition"
    HELP = "write `@{path}`"

    path: str


class NotAMethod(TemplateMessage):
    """The target of `call` is not a method."""

    CODE = "E0456"
    TEXT = "the target of `call` is not a method"


class EventMismatch(TemplateMessage):
    """An event whose parameters differ from those of the event it overrides."""

    CODE = "E0457"
    TEXT = "`{name}` differs from the event that it overrides in {difference}"
    HELP = "only defaults and the specification after `is` may differ"
    OTHERS = (("first", "the overridden event is here"),)

    name: str
    difference: str
    first: Span
