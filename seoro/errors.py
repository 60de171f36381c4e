"""Exceptions, named by whose fault they are.

SeoroError
|-- InvalidScenario   the scenario's text: has diagnostics, prints them with carets
|-- InvalidUse        the caller: an option, a name, a combination that cannot work
|-- ActionFailed      the system under test: an action did not reach what it was asked for
`-- BackendError      a simulator or a robot's bridge
    |-- BackendRefused    it said no to a request, with a reason
    |   `-- BackendStopped    somebody has stopped all that moves
    `-- BackendLost       it is gone, or does not answer any more
        `-- BackendUnreachable    it is not there (yet): a later attempt may succeed
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from seoro.lang.diagnostic import Diagnostic
    from seoro.lang.source import Span

CONFLICT: Final = "E0442"  # code of constraints that cannot hold together


class SeoroError(Exception):
    """Base of all exceptions of seoro."""


class InvalidScenario(SeoroError):
    """The scenario's text has errors; `diagnostics` says which and where."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__(f"{len(diagnostics)} diagnostics")
        self.diagnostics = tuple(diagnostics)

    def __str__(self) -> str:
        from seoro.lang.render import render_text  # noqa: PLC0415 - only needed when it is printed

        return "\n\n".join(render_text(diagnostic) for diagnostic in self.diagnostics)


class InvalidUse(SeoroError):
    """What the caller asked for cannot be done.

    Args:
        message: What is wrong.
        span: The text of the scenario that asks for it, if any does.
        help: What would work.
        places: The places in the text that have to do with it, each with what to say of it; the first is the span.
        code: What `seoro explain` knows it by.
    """

    def __init__(
        self,
        message: str,
        span: Span | None = None,
        help: str = "",  # noqa: A002
        places: tuple[tuple[Span, str], ...] = (),
        code: str = "E0500",
    ) -> None:
        super().__init__(message)
        if help and span is None:
            self.add_note(f"help: {help}")
        self.message = message
        self.span = span
        self.help = help
        self.places = places
        self.code = code

    @property
    def diagnostic(self) -> Diagnostic | None:
        """The message with its code and places; None if the text of the scenario has nothing to do with it."""
        from seoro.lang.diagnostic import Diagnostic, Label, Severity  # noqa: PLC0415 - only needed for messages

        if self.span is None:
            return None
        first, *others = [Label(place, text) for place, text in self.places] or [Label(self.span, "")]
        return Diagnostic(Severity.ERROR, self.code, self.message, first, tuple(others), help=self.help)

    def __str__(self) -> str:
        from seoro.lang.render import render_text  # noqa: PLC0415 - only needed when it is printed

        found = self.diagnostic
        return self.message if found is None else render_text(found)


def cause_of(error: Exception) -> Exception:
    """Return the first exception of nested exception groups, which task groups make; else the exception itself."""
    while isinstance(error, ExceptionGroup):
        error = error.exceptions[0]
    return error


class ActionFailed(SeoroError):
    """An action did not reach what it was asked for. Raised by actions; the scenario goes on from there."""


class BackendError(SeoroError):
    """A simulator or a robot's bridge did not do its part."""


class BackendRefused(BackendError):
    """A backend said no.

    Args:
        message: Its reason, for people.
        code: Its result code (`simulation_interfaces`).
    """

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


class BackendStopped(BackendRefused):
    """Somebody has stopped all that moves there: neither the scenario nor what it tests is at fault."""


class BackendLost(BackendError):
    """A backend is gone, or does not answer any more."""


class BackendUnreachable(BackendLost):
    """A backend cannot be reached, or is busy or ending; a later attempt may succeed.

    Args:
        message: The endpoint and the node that was expected there.
        help: How to start one.
    """

    def __init__(self, message: str, help: str = "") -> None:  # noqa: A002
        super().__init__(message)
        if help:
            self.add_note(f"help: {help}")
        self.help = help
