"""Messages about source text, as data: what is wrong, where, and what to do about it.

Every message of a phase is a small immutable class in `diagnostics/`, whose fields say what the message is
about and which turns itself into a `Diagnostic`. `render.py` shows diagnostics to people and programs.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, Protocol

from seoro.lang.frozen import Value
from seoro.lang.source import Span

MAX_ERRORS: Final = 300  # of a phase
MAX_TEXT: Final = 1000  # characters of a message


class Severity(Enum):
    """How bad it is: only an error keeps a scenario from running."""

    ERROR = "error"
    WARNING = "warning"


class Label(Value):
    """A remark on a stretch of text."""

    span: Span
    text: str


class Diagnostic(Value):
    """One message.

    Args:
        severity: Error or warning.
        code: `E0312`-like; the first two digits tell the phase: 01 syntax, 02 names and imports, 03 types,
            04 behaviors and instantiation, 05 coverage and runs, 06 Python, 09 what is not supported yet.
        message: One line, without a full stop.
        primary: Where it is, and what to say there (may be empty).
        secondary: Other places that explain it.
        help: What to do; may be empty.
    """

    severity: Severity
    code: str
    message: str
    primary: Label
    secondary: tuple[Label, ...] = ()
    help: str = ""

    @property
    def position(self) -> tuple[str, int, int]:
        """What diagnostics are sorted by: file, then place."""
        span = self.primary.span
        return span.file.name, span.start, span.end


class Message(Protocol):
    """What the classes in `diagnostics/` have in common."""

    def diagnostic(self) -> Diagnostic:
        """The message as a diagnostic."""
        ...


@dataclass
class Bag:
    """Collects the messages of a phase; the same message at the same place counts once.

    With many errors, no more are taken: nobody reads them, and to word each takes time.
    """

    _found: dict[tuple[str, str, str, int], Diagnostic] = field(default_factory=dict)
    _errors: int = 0
    _dropped: int = 0
    _copies: list[Diagnostic] | None = None

    def add(self, message: Message) -> None:
        """Take a message."""
        if self._errors >= MAX_ERRORS:
            self._dropped += 1
            return
        self.put(message.diagnostic())

    def put(self, found: Diagnostic) -> None:
        """Take a message that is worded already."""
        if self._copies is not None:
            self._copies.append(found)
        span = found.primary.span
        key = (found.code, found.message, span.file.name, span.start)
        if key not in self._found:
            self._found[key] = found
            self._errors += found.severity is Severity.ERROR

    @contextmanager
    def copied(self) -> Iterator[list[Diagnostic]]:
        """Copy what is taken within the block, known messages as well."""
        copies: list[Diagnostic] = []
        self._copies = copies
        try:
            yield copies
        finally:
            self._copies = None

    @property
    def is_full(self) -> bool:
        """Whether no more messages are taken."""
        return self._errors >= MAX_ERRORS

    def __len__(self) -> int:
        return len(self._found) + self._dropped

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All messages, in the order in which they were found."""
        return tuple(self._found.values())


def _short(text: str) -> str:
    """A text without its middle if it is too long to be read; names and strings of a file have any length."""
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT // 2]}...{text[-MAX_TEXT // 2 :]}"


def error(
    code: str,
    span: Span,
    message: str,
    *secondary: Label,
    label: str = "",
    help: str = "",  # noqa: A002
) -> Diagnostic:
    """An error, shortly written."""
    return Diagnostic(Severity.ERROR, code, _short(message), Label(span, _short(label)), secondary, _short(help))


def warning(code: str, span: Span, message: str, label: str = "", help: str = "") -> Diagnostic:  # noqa: A002
    """A warning, shortly written."""
    return Diagnostic(Severity.WARNING, code, _short(message), Label(span, _short(label)), (), _short(help))
