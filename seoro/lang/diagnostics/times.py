"""Messages of times, and of the arguments of compositions (E0454, E0480 to E0482)."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage


class NegativeTime(TemplateMessage):
    """An invalid time literal.

    Args:
        is_positive: Whether zero is invalid, too.
    """

    CODE = "E0454"
    TEXT = ("{is_positive:if}the {what} must be longer than zero", "the {what} must not be negative")
    HELP = ("{is_positive:if}use more than `0s`", "use `0s` or more")

    what: str
    is_positive: bool


class ParallelOnly(TemplateMessage):
    """An argument of `parallel` for another composition (7.3.13.2)."""

    CODE = "E0480"
    TEXT = "`{name}` is a parameter of `parallel`, not of `{operator}`"

    name: str
    operator: str


class UnknownOverlap(TemplateMessage):
    """An unknown kind of overlap (7.3.13.2)."""

    CODE = "E0481"
    TEXT = "unknown kind of overlap `{name}`"
    HELP = ("{near}", "the kinds are {candidates:and}")

    candidates: tuple[str, ...]

    @property
    def name(self) -> str:
        """The kind as written."""
        return self.span.text


class ContradictoryOffset(TemplateMessage):
    """An offset that the kind of overlap excludes (7.3.13.2)."""

    CODE = "E0482"
    TEXT = "with `overlap: {overlap}`, `{name}` has to be {_expected}"
    HELP = "`overlap: any` allows any offset"

    name: str
    overlap: str
    low: float
    high: float

    @property
    def _expected(self) -> str:
        return "zero" if self.low == self.high else "zero or more" if self.low == 0 else "zero or less"
