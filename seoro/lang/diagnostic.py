"""Diagnostics: messages about source text with a code, spans and help.

Each message is declared by a function in `diagnostics/`, which fills its texts.
`render.py` prints diagnostics as text or JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import field
from enum import Enum
from typing import Final, ParamSpec

from seoro.deferred import dataclass
from seoro.lang.frozen import Value, replaced
from seoro.lang.source import Span

MAX_ERRORS: Final = 300  # of a phase
MAX_TEXT: Final = 1000  # characters of a message
P = ParamSpec("P")


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
            03 types, 04 behaviors and instantiation, 05 coverage and runs, 06 Python. 07 denotes suspicious code,
            and 09 unsupported constructs.
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


def error(
    code: str, span: Span, text: str, hint: str = "", label: str = "", other: Span | None = None, remark: str = ""
) -> Diagnostic:
    """Create an error; the middle of overlong texts is left out, as names and strings can have any length.

    Args:
        code: The code.
        span: The primary span.
        text: The message.
        hint: Suggested fix.
        label: Remark at the span.
        other: Another span that explains it, if any.
        remark: Remark at the other span.
    """
    others = () if other is None else (Label(other, _shortened(remark)),)
    labels = Label(span, _shortened(label)), others
    return Diagnostic(Severity.ERROR, code, _shortened(text), *labels, _shortened(hint))


def warning(code: str, span: Span, text: str, hint: str = "") -> Diagnostic:
    """Create a warning, like `error`."""
    return replaced(error(code, span, text, hint), severity=Severity.WARNING)


def _shortened(text: str) -> str:
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT // 2]}...{text[-MAX_TEXT // 2 :]}"


@dataclass(eq=False)
class Bag:
    """Collects the diagnostics of a phase; equal messages at the same place count once.

    After `MAX_ERRORS` errors, further messages are dropped, since formatting takes time.
    """

    _found: dict[tuple[str, str, str, int], Diagnostic] = field(default_factory=dict)
    _errors: int = 0
    _dropped: int = 0
    _copies: list[Diagnostic] | None = None

    def add(self, make: Callable[P, Diagnostic], /, *args: P.args, **named: P.kwargs) -> None:
        """Add the message that a function of `diagnostics/` makes, or count it as dropped if the bag is full."""
        if self.is_full:
            self._dropped += 1
        else:
            self.put(make(*args, **named))

    def put(self, found: Diagnostic) -> None:
        """Add a diagnostic, or count it as dropped if the bag is full."""
        if self.is_full:
            self._dropped += 1
            return
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
