"""Diagnostics of errors that are about the text of a scenario, for people and programs."""

from __future__ import annotations

from dataclasses import replace

from seoro.errors import InvalidScenario, InvalidUse
from seoro.lang.diagnostic import Diagnostic
from seoro.terminal_text import printable


def diagnostics_of(error: Exception) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of an error; empty for one that is not about the text of a scenario."""
    match error:
        case InvalidScenario(diagnostics=diagnostics):
            return diagnostics
        case InvalidUse(diagnostic=Diagnostic() as found):
            return (replace(found, message=printable(found.message)),)
        case _:
            return ()
