"""Diagnostics of errors that are about the text of a scenario, for people and programs."""

from __future__ import annotations

from seoro.errors import InvalidScenario, InvalidUse
from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.source import Span
from seoro.reasons import printable


def diagnostics_of(error: Exception) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of an error; empty for one that is not about the text of a scenario."""
    match error:
        case InvalidScenario(diagnostics=diagnostics):
            return diagnostics
        case InvalidUse(span=Span() as span):
            first, *others = [Label(place, text) for place, text in error.places] or [Label(span, "")]
            message = printable(str(error))
            return (Diagnostic(Severity.ERROR, error.code, message, first, tuple(others), help=error.help),)
        case _:
            return ()
