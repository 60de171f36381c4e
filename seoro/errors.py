"""Exceptions, named by whose fault they are.

SeoroError
|-- InvalidScenario   the scenario's text; has diagnostics, and prints them with carets
|-- UsageError        the caller: an invalid option, name or combination
|   `-- SubscriptionOverflow    it receives events more slowly than they occur
|-- ActionFailed      the system under test: an action did not reach its goal
`-- BackendError      a simulator or a robot's bridge
    |-- BackendRefused    it refused a request, with a reason
    |   `-- BackendStopped    it is under an emergency stop
    `-- BackendLost       the connection is lost, or it does not answer
        `-- BackendUnreachable    it is not up (yet); a later attempt may succeed
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
    """The scenario's text has errors; `diagnostics` lists them with their places."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__(f"{len(diagnostics)} diagnostics")
        self.diagnostics = tuple(diagnostics)

    def __str__(self) -> str:
        from seoro.lang.render import render_text  # noqa: PLC0415 - only needed when it is printed

        return "\n\n".join(render_text(diagnostic) for diagnostic in self.diagnostics)


class UsageError(SeoroError):
    """The request of the caller is invalid.

    Args:
        message: Description of the error.
        span: Place of the request in the text of the scenario, if any.
        help: Suggestion for a fix.
        places: Related places in the text, each with a label; the first is the span.
        code: Code for `seoro explain`.
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
        """The message with its code and places; None if the error has no place in a scenario."""
        from seoro.lang.diagnostic import Diagnostic, Label, Severity  # noqa: PLC0415 - only needed for messages

        if self.span is None:
            return None
        first, *others = [Label(place, text) for place, text in self.places] or [Label(self.span, "")]
        return Diagnostic(Severity.ERROR, self.code, self.message, first, tuple(others), help=self.help)

    def __str__(self) -> str:
        from seoro.lang.render import render_text  # noqa: PLC0415 - only needed when it is printed

        found = self.diagnostic
        return self.message if found is None else render_text(found)


class SubscriptionOverflow(UsageError):
    """A subscription with `on_full="fail"` received more slowly than its event occurred.

    Args:
        event: The event.
        capacity: Capacity of the buffer.
        lost: Number of lost occurrences.
    """

    def __init__(self, event: str, capacity: int, lost: int) -> None:
        super().__init__(
            f"the buffer of the subscription to `{event}` was full (capacity {capacity}): {lost} "
            f"{'occurrence was' if lost == 1 else 'occurrences were'} lost",
            help='receive faster, give a larger `capacity`, or use `on_full="drop_oldest"` or `on_full="wait"`',
        )
        self.lost = lost


def cause_of(error: Exception) -> Exception:
    """Return the first exception in nested exception groups of task groups; otherwise the exception itself."""
    while isinstance(error, ExceptionGroup):
        error = error.exceptions[0]
    return error


class ActionFailed(SeoroError):
    """An action did not reach its goal. Raised by actions; the scenario reacts to it."""


class BackendError(SeoroError):
    """A simulator or a robot's bridge failed."""


class BackendRefused(BackendError):
    """A backend refused a request.

    Args:
        message: Reason, for people.
        code: Result code (`simulation_interfaces`).
    """

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


class BackendStopped(BackendRefused):
    """A backend is under an emergency stop; neither the scenario nor the system under test is at fault."""


class BackendLost(BackendError):
    """The connection to a backend is lost, or the backend does not answer."""


class BackendUnreachable(BackendLost):
    """A backend cannot be reached, or is busy or ending; a later attempt may succeed.

    Args:
        message: Endpoint, and the node that was expected there.
        help: Suggestion how to start the backend.
    """

    def __init__(self, message: str, help: str = "") -> None:  # noqa: A002
        super().__init__(message)
        if help:
            self.add_note(f"help: {help}")
        self.help = help
