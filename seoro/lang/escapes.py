"""Escapes in string literals: a subset of those of Python (7.2.1.5.2, 7.3.2.4)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

# Both are compiled on first use: few texts have escapes.
_ESCAPE: Final = r"(?s)\\(x[0-9a-fA-F]{2}|u[0-9a-fA-F]{4}|U(?:000[0-9a-fA-F]|0010)[0-9a-fA-F]{4}|\r\n|.)"
_ESCAPED: Final = {
    "n": "\n", "t": "\t", "r": "\r", "\\": "\\", "'": "'", '"': '"', "\n": "", "\r": "", "\r\n": "",
    "a": "\a", "b": "\b", "f": "\f", "v": "\v",
}  # fmt: skip
_SIMPLE: Final = r"\\(?:[ntr\\'\"\nabfv]|\r\n?)"  # those of `_ESCAPED`
ESCAPES: Final = r"\n, \t, \r, \a, \b, \f, \v, \\, \', \", \xhh, \uhhhh and \Uhhhhhhhh"


def unescape(text: str) -> str:
    """Resolve the escapes of Python, except octal and named ones; others keep their backslash."""
    if "\\" not in text:
        return text
    return re.sub(_ESCAPE, _escaped, text)


def _escaped(found: re.Match[str]) -> str:
    """Resolve an escape; half of a surrogate pair stays unchanged."""
    escape = found[1]
    if escape in _ESCAPED or len(escape) < 3:
        return _ESCAPED.get(escape, found[0])
    number = int(escape[1:], 16)
    return found[0] if 0xD800 <= number < 0xE000 else chr(number)


def unknown_escapes(literal: str) -> Iterator[tuple[int, int]]:
    """Find the unknown escapes of a string literal, which keep their backslash.

    Args:
        literal: The text of the literal, with its quotes.

    Returns:
        Start and end of each.
    """
    if "\\" not in literal or "\\" not in re.sub(_SIMPLE, "", literal):  # most have simple ones only
        return
    for found in re.finditer(_ESCAPE, literal):
        if _escaped(found) == found[0]:
            yield found.span()
