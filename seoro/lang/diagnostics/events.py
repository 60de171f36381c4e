"""Messages of events and of the directives that emit and await them (E0408 to E0412, E0450 to E0457)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error
from seoro.lang.diagnostics import a, listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class UnknownEvent(Frozen):
    """An event that is not declared.

    Args:
        owner: What has no such event; empty for what is around.
        is_phase: Whether it is one of those that scenarios have.
        is_label: Whether it is a label.
    """

    span: Span
    name: str
    candidates: tuple[str, ...]
    owner: str = ""
    is_phase: bool = False
    is_label: bool = False

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.owner}` has no event `{self.name}`" if self.owner else f"unknown event `{self.name}`"
        hint = near(self.name, self.candidates)
        if self.is_label:
            hint = f"`{self.name}` is a label: write `@{self.name}.end` or `@{self.name}.start`"
        elif self.is_phase:
            hint = "`start`, `end` and `fail` are events of scenarios, actions and labels"
        elif not hint and self.owner:
            hint = f"it has {listing(self.candidates)}" if self.candidates else "it has no events"
        return error("E0408", self.span, text, help=hint)


class UnknownLabel(Frozen):
    """A label that no behavior of the scenario has."""

    span: Span
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.candidates)
        return error("E0409", self.span, f"`{self.name}` is neither a label nor a field here", help=hint)


class UnknownPhase(Frozen):
    """An event of a label that it does not have."""

    span: Span
    label: str
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "a label has `start`, `end` and `fail`"
        return error("E0410", self.span, f"`{self.label}` has no event `{self.name}`", help=hint)


class EmitStart(Frozen):
    """`emit start`."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "`start` occurs by itself when a scenario starts; `emit end` and `emit fail` end it"
        return error("E0411", self.span, "`start` cannot be emitted", help=hint)


class NoEvent(Frozen):
    """An `@` before something that is no event."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "events are `@event`, `@field.event`, and `start`, `end` or `fail` as in `@label.end`"
        return error("E0412", self.span, "this is no event", help=hint)


class NoEvents(Frozen):
    """The event of a value that cannot have events."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "structs, actors and what runs under a label have events"
        return error("E0450", self.span, f"`{self.span.text}` is {a(self.found)}, which has no events", help=hint)


class OccurrenceHidesField(Frozen):
    """The name of an occurrence that a field has (7.3.10.4)."""

    span: Span
    name: str
    first: Span | None  # None if the field is implicit

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = (Label(self.first, "the field is here"),) if self.first is not None else ()
        hint = "choose another name after `as`"
        return error("E0451", self.span, f"`{self.name}` is the name of a field already", *before, help=hint)


class SpecificationWithParameters(Frozen):
    """An event with parameters and a specification, which could not give them values (7.3.10.2)."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.name}` has parameters, so nothing but `emit` can make it occur"
        return error("E0452", self.span, text, help="leave out the parameters, or what stands behind `is`")


class PredefinedEvent(Frozen):
    """The declaration of an event that there is without it (7.3.10.3)."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"every scenario, action and modifier has the event `{self.name}` already"
        return error("E0453", self.span, text, help="choose another name")


class MissingAt(Frozen):
    """The path of an event in the place of a condition."""

    span: Span
    path: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error(
            "E0455", self.span, f"`{self.path}` is an event, not a condition", help=f"write `@{self.path}`"
        )


class NotAMethod(Frozen):
    """`call` of what is no method."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0456", self.span, "`call` calls a method, and this is none")


class OtherParameters(Frozen):
    """An event with other parameters than the one of a base that it overrides."""

    span: Span
    name: str
    difference: str
    first: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.first, "the overridden one is here")
        text = f"`{self.name}` differs from the event that it overrides in {self.difference}"
        return error(
            "E0457", self.span, text, before, help="only defaults and what stands behind `is` may be others"
        )
