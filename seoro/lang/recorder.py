"""What checking tells, on request, of every name and every expression that it comes across.

Editors ask where a name is declared and of what type a value is; the plan has no use for either. So nothing is
kept, unless whoever starts the check hands in a recorder.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from seoro.lang.frozen import Value
from seoro.lang.source import Span

if TYPE_CHECKING:
    from seoro.lang.symbols import EnumSymbol
    from seoro.lang.types import Type


class EnumMember(Value):
    """A member of an enumeration, as what a name means; all other names mean a symbol."""

    enum: EnumSymbol
    text: str


class Recorder(Protocol):
    """Takes notes while a scenario is checked."""

    def name(self, span: Span, meaning: object) -> None:
        """A name at a place means a symbol; what is told later of one place replaces what was told before."""
        ...

    def value(self, span: Span, type_: Type) -> None:
        """An expression has a type."""
        ...
