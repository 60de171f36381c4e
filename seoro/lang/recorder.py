"""Interface of recorders: receivers of the meanings of names and the types of values during a check.

Editors need both, the plan needs neither. Without a recorder, they are not stored.
"""

from __future__ import annotations

from typing import Protocol

from seoro.lang.frozen import Value
from seoro.lang.source import Span
from seoro.lang.symbols import EnumSymbol, Type


class EnumMember(Value):
    """A member of an enumeration as the meaning of a name; all other names denote symbols."""

    enum: EnumSymbol
    text: str


class Recorder(Protocol):
    """Receiver of names and values during a check."""

    def name(self, span: Span, meaning: object) -> None:
        """Record the meaning of a name; later calls for the same span replace earlier ones."""
        ...

    def value(self, span: Span, type_: Type) -> None:
        """Record the type of an expression."""
        ...
