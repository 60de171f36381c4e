"""Comments of declarations."""

from __future__ import annotations

from itertools import takewhile

from seoro.lang.source import SourceFile


def comment_above(file: SourceFile, line: int) -> str:
    """Return the text of the `#` lines directly above a line.

    Args:
        file: The file.
        line: Number of the line, from 1.
    """
    above = (file.line(number).strip() for number in range(line - 1, 0, -1))
    found = [text.lstrip("#").removeprefix(" ") for text in takewhile(lambda text: text.startswith("#"), above)]
    return "\n".join(reversed(found))
