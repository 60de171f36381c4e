"""Messages of times, and of the arguments of compositions (E0454, E0480 to E0482)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import near_or_all
from seoro.lang.source import Span


def negative_time(span: Span, what: str, is_positive: bool) -> Diagnostic:
    """An invalid time literal.

    Args:
        span: The literal.
        what: What the time means.
        is_positive: Whether zero is invalid, too.
    """
    if is_positive:
        return error("E0454", span, f"the {what} must be longer than zero", "use more than `0s`")
    return error("E0454", span, f"the {what} must not be negative", "use `0s` or more")


def parallel_only(span: Span, name: str, operator: str) -> Diagnostic:
    """An argument of `parallel` for another composition (7.3.13.2)."""
    return error("E0480", span, f"`{name}` is a parameter of `parallel`, not of `{operator}`")


def unknown_overlap(span: Span, candidates: tuple[str, ...]) -> Diagnostic:
    """An unknown kind of overlap (7.3.13.2)."""
    hint = near_or_all(span.text, candidates, "the kinds are")
    return error("E0481", span, f"unknown kind of overlap `{span.text}`", hint)


def contradictory_offset(span: Span, name: str, overlap: str, low: float, high: float) -> Diagnostic:
    """An offset that the kind of overlap excludes (7.3.13.2)."""
    expected = "zero" if low == high else "zero or more" if low == 0 else "zero or less"
    text = f"with `overlap: {overlap}`, `{name}` has to be {expected}"
    return error("E0482", span, text, "`overlap: any` allows any offset")
