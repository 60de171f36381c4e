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

    WITH = "03", "a `with:` block"
    SAMPLE = "04", "`sample`"
    ON = "05", "`on`"
    CALL = "06", "`call`"
    COMPOSITION_ARGUMENTS = "07", "an argument of `serial`, `parallel` or `one_of`"
    MODIFIER_DECLARATION = "08", "the declaration of a modifier"
    MODIFIER_APPLICATION = "09", "the application of a modifier"
    RISE = "10", "`rise`"
    FALL = "11", "`fall`"
    EVERY = "12", "`every`"
    BOOL_CONDITION = "13", "waiting for a condition"
    EVENT_IS = "14", "`is` in the declaration of an event"
    COVERAGE = "17", "`cover` or `record` in an action or a modifier"
    REFERENCE = "28", "an argument that is the path of a variable"
    FOREIGN_EVENT = "29", "an event of another object"
    DURATION = "32", "the `duration` of an invocation"
    ITEM_EVENT = "40", "sampling at an event of a struct or an actor"
    ELAPSED_CONDITION = "31", "`elapsed` as the condition of an event"


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
