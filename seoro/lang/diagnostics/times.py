"""Messages of times, and of the arguments of compositions (E0454, E0480 to E0489)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class NegativeTime(Frozen):
    """A time that is written out and cannot be."""

    span: Span
    what: str
    is_positive: bool  # whether it cannot be zero, either

    def diagnostic(self) -> Diagnostic:
        """The message."""
        needed = "be longer than zero" if self.is_positive else "not be negative"
        least = "more than `0s`" if self.is_positive else "`0s` or more"
        return error("E0454", self.span, f"the {self.what} must {needed}", help=f"give it {least}")


class ParallelOnly(Frozen):
    """An argument of `parallel`, given to another composition (7.3.13.2)."""

    span: Span
    name: str
    operator: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.name}` is a parameter of `parallel`, not of `{self.operator}`"
        return error("E0480", self.span, text)


class UnknownOverlap(Frozen):
    """What is no kind of overlap (7.3.13.2)."""

    span: Span
    kinds: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = self.span.text
        hint = near(text, self.kinds) or f"the kinds are {listing(self.kinds)}"
        return error("E0481", self.span, f"`{text}` is no kind of overlap", help=hint)


class ContradictoryOffset(Frozen):
    """An offset that the kind of overlap excludes (7.3.13.2)."""

    span: Span
    name: str
    overlap: str
    low: float
    high: float

    def diagnostic(self) -> Diagnostic:
        """The message."""
        needed = "zero" if self.low == self.high else "zero or more" if self.low == 0 else "zero or less"
        text = f"with `overlap: {self.overlap}`, `{self.name}` has to be {needed}"
        return error("E0482", self.span, text, help="`overlap: any` allows any offset")
