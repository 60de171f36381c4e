"""Diagnostics: messages about source text with a code, spans and help.

Each message is declared by a small frozen class in `diagnostics/`, which fills its templates.
`render.py` prints diagnostics as text or JSON.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import field
from enum import Enum
from typing import Final, Protocol

from seoro.lang.frozen import Value
from seoro.lang.lazy_dataclass import lazy_dataclass
from seoro.lang.source import Span

MAX_ERRORS: Final = 300  # of a phase
MAX_TEXT: Final = 1000  # characters of a message


class Severity(Enum):
    """Severity of a diagnostic: only errors prevent a run."""

    ERROR = "error"
    WARNING = "warning"


class Label(Value):
    """A span of source text with a remark."""

    span: Span
    text: str


class Diagnostic(Value):
    """One message.

    Args:
        severity: Error or warning.
        code: A code like `E0312`. The first two digits denote the phase: 01 syntax, 02 names and imports,
            03 types, 04 behaviors and instantiation, 05 coverage and runs, 06 Python, 09 unsupported constructs.
        message: One line, without a full stop.
        primary: Its span, with a remark that may be empty.
        secondary: Other spans that explain it.
        help: Suggested fix; may be empty.
    """

    severity: Severity
    code: str
    message: str
    primary: Label
    secondary: tuple[Label, ...] = ()
    help: str = ""

    @property
    def position(self) -> tuple[str, int, int]:
        """Sort key: file, then span."""
        span = self.primary.span
        return span.file.name, span.start, span.end


class Message(Protocol):
    """Interface of the classes in `diagnostics/`."""

    @property
    def span(self) -> Span:
        """Span of the diagnostic."""
        ...

    def diagnostic(self) -> Diagnostic:
        """Create the diagnostic."""
        ...


@lazy_dataclass
class Bag:
    """Collects the diagnostics of a phase; equal messages at the same place count once.

    After `MAX_ERRORS` errors, further messages are dropped, since formatting takes time.
    """

    _found: dict[tuple[str, str, str, int], Diagnostic] = field(default_factory=dict)
    _errors: int = 0
    _dropped: int = 0
    _copies: list[Diagnostic] | None = None

    def add(self, message: Message) -> None:
        """Add a message, or count it as dropped if the bag is full."""
        if self._errors >= MAX_ERRORS:
            self._dropped += 1
            return
        self.put(message.diagnostic())

    def put(self, found: Diagnostic) -> None:
        """Add a diagnostic."""
        if self._copies is not None:
            self._copies.append(found)
        span = found.primary.span
        key = (found.code, found.message, span.file.name, span.start)
        if key not in self._found:
            self._found[key] = found
            self._errors += found.severity is Severity.ERROR

    @contextmanager
    def copied(self) -> Iterator[list[Diagnostic]]:
        """Record the diagnostics that are added within the block, duplicates included."""
        copies: list[Diagnostic] = []
        self._copies = copies
        try:
            yield copies
        finally:
            self._copies = None

    @property
    def is_full(self) -> bool:
        """Whether further messages are dropped."""
        return self._errors >= MAX_ERRORS

    def __len__(self) -> int:
        return len(self._found) + self._dropped

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics, in the order in which they were added."""
        return tuple(self._found.values())
