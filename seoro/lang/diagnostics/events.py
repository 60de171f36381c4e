"""Messages of events and of the directives that emit and await them (E0408 to E0412, E0450 to E0457)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import near, near_or_all, with_article
from seoro.lang.source import Span


def unknown_event(
    span: Span,
    name: str,
    candidates: tuple[str, ...],
    owner: str = "",
    is_phase: bool = False,
    is_label: bool = False,
) -> Diagnostic:
    """An undeclared event.

    Args:
        span: Its name.
        name: Its identifier.
        candidates: The known events.
        owner: Owner that lacks the event; empty for the surrounding scope.
        is_phase: Whether the name is that of an event of scenarios.
        is_label: Whether the name is that of a label.
    """
    if is_label:
        hint = f"`{name}` is a label: write `@{name}.end` or `@{name}.start`"
    elif is_phase:
        hint = "`start`, `end` and `fail` are events of scenarios, actions and labels"
    elif owner:
        hint = near_or_all(name, candidates, "its events are") or "it has no events"
    else:
        hint = near(name, candidates)
    return error("E0408", span, f"`{owner}` has no event `{name}`" if owner else f"unknown event `{name}`", hint)


def unknown_label(span: Span, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """A label that no behavior of the scenario has."""
    return error("E0409", span, f"unknown label or field `{name}`", near(name, candidates))


def unknown_phase(span: Span, label: str, name: str) -> Diagnostic:
    """An unknown event of a label."""
    return error("E0410", span, f"`{label}` has no event `{name}`", "a label has `start`, `end` and `fail`")


def emit_start(span: Span) -> Diagnostic:
    """`emit start`."""
    hint = "`start` occurs when a scenario starts; `emit end` and `emit fail` end it"
    return error("E0411", span, "`start` cannot be emitted", hint)


def not_an_event(span: Span) -> Diagnostic:
    """An `@` before something other than an event."""
    hint = "events are `@event`, `@field.event`, and `start`, `end` or `fail` as in `@label.end`"
    return error("E0412", span, "expected an event after `@`", hint)


def no_events(span: Span, found: str) -> Diagnostic:
    """An event of a value that cannot have events."""
    hint = "events belong to structs, actors and labelled behaviors"
    return error("E0450", span, f"`{span.text}` is {with_article(found)}, which has no events", hint)


def occurrence_hides_field(span: Span, name: str, first: Span | None) -> Diagnostic:
    """An occurrence with the name of a field (7.3.10.4).

    Args:
        first: The field; None if it is implicit.
    """
    text = f"`{name}` is already the name of a field"
    hint = "choose another name after `as`"
    return error("E0451", span, text, hint, other=first, remark="the field is here")


def specification_with_parameters(span: Span, name: str) -> Diagnostic:
    """An event with parameters and a specification, which cannot give them values (7.3.10.2)."""
    hint = "remove the parameters, or the specification after `is`"
    return error("E0452", span, f"`{name}` has parameters, so only `emit` can make it occur", hint)


def predefined_event(span: Span, name: str) -> Diagnostic:
    """The declaration of a predefined event (7.3.10.3)."""
    hint = "choose another name"
    return error("E0453", span, f"every scenario, action and modifier already has the event `{name}`", hint)


def missing_at(span: Span, path: str) -> Diagnostic:
    """The path of an event in the place of a condition."""
    return error("E0455", span, f"`{path}` is an event, not a condition", f"write `@{path}`")


def not_a_method(span: Span) -> Diagnostic:
    """The target of `call` is not a method."""
    return error("E0456", span, "the target of `call` is not a method")


def event_mismatch(span: Span, name: str, difference: str, first: Span) -> Diagnostic:
    """An event whose parameters differ from those of the event it overrides."""
    text = f"`{name}` differs from the event that it overrides in {difference}"
    hint = "only defaults and the specification after `is` may differ"
    return error("E0457", span, text, hint, other=first, remark="the overridden event is here")
