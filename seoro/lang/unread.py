"""Names that statements with syntax errors may declare: unknown uses of them are echoes of those errors."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Final

from seoro.lang.lexer import LAYOUT, Token

_DECLARES_NOTHING: Final = frozenset(
    {"keep", "remove_default", "wait", "emit", "call", "until", "on", "cover", "record", "with", "export"}
)
_DECLARES_ANYTHING: Final = frozenset({"import", "namespace", "include", "from"})


def names_declared(tokens: Sequence[Token], lost: Sequence[tuple[int, int]]) -> tuple[str, ...] | None:
    """Return the names that unparsable statements may declare; None for any name.

    Args:
        tokens: The tokens of the file.
        lost: Starts and ends of the statements.
    """
    names: dict[str, None] = {}
    stretches = sorted(lost)
    starts = [start for start, _ in stretches]
    statement: list[str] = []
    for token in tokens if lost else ():
        number = bisect_right(starts, token.start) - 1
        is_lost = number >= 0 and token.start < stretches[number][1]
        if is_lost and token.kind not in LAYOUT:
            if isinstance(token.value, str):
                statement.append(_bare(token))
            continue
        if statement and statement[0] in _DECLARES_ANYTHING:
            return None
        if statement and statement[0] not in _DECLARES_NOTHING:
            names |= dict.fromkeys(statement)
        statement = []
    return tuple(names)


def _bare(token: Token) -> str:
    """Return the identifier of a name, without prefix and bars."""
    text = str(token.value)
    return text.rpartition("::")[2].strip("|") if token.kind in {"NAME", "PREFIXED"} else ""
