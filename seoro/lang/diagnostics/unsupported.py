"""What the language has and seoro does not support yet (E09): each is refused by name, never ignored.

An entry disappears with the support for it.
"""

from __future__ import annotations

from enum import Enum

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class Construct(Enum):
    """What is refused: the code's last two digits, and how the message calls it."""

    CONSTRAINED_COMPOSITION = "03", "a constraint on a composition"
    IT_OF_COMPOSITION = "34", "`it` for a composition, or in a modifier without `of`"


class NotSupported(Frozen):
    """A construct of the standard that is not supported yet."""

    span: Span
    construct: Construct
    name: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        code, what = self.construct.value
        named = f" (`{self.name}`)" if self.name else ""
        return error(f"E09{code}", self.span, f"{what}{named} is not supported yet")
