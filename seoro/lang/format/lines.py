"""Reader of logical lines with comments, blank lines and line breaks, which tokens lack."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, NamedTuple

from seoro.lang.lexer import TAB_STOP, Token
from seoro.lang.source import SourceFile

_GAP: Final = re.compile(r"(?P<comment>#[^\r\n]*)|(?P<joined>\\(?:\r\n|\r|\n))|(?P<end>\r\n|\r|\n)")
_UNTOUCHED: Final = re.compile(r"#(?:[ #!:]|$)")  # comments that get no blank after the `#`


class Comment(NamedTuple):
    """A comment.

    Args:
        text: With its `#`, and a blank behind that.
        column: Column in the source, from 0; tabs advance to multiples of eight, as in the lexer.
        is_alone: Whether nothing else stood before it on its line.
        after_blank: Whether a blank line came before it.
    """

    text: str
    column: int
    is_alone: bool
    after_blank: bool


class Gap(NamedTuple):
    """Comments and line breaks between two tokens.

    Args:
        comments: The comments.
        has_end: Whether a line ends there.
        ends_blank: Whether a blank line comes after the last comment.
    """

    comments: tuple[Comment, ...]
    has_end: bool
    ends_blank: bool


class LogicalLine(NamedTuple):
    """A statement, or its first line if it opens a block.

    Args:
        before: Comments and blank lines above it.
        level: Number of enclosing blocks.
        column: Column of its start, from 0.
        columns: The columns of the blocks that were open above it, the outermost first.
        tokens: Its tokens.
        gaps: Gap after each token; the last one ends with the line.
        opens_block: Whether an indented block follows.
    """

    before: Gap
    level: int
    column: int
    columns: tuple[int, ...]
    tokens: tuple[Token, ...]
    gaps: tuple[Gap, ...]
    opens_block: bool


class FileLines(NamedTuple):
    """All logical lines of a file; `rest` follows the last one, whose blocks have these `columns`."""

    lines: tuple[LogicalLine, ...]
    columns: tuple[int, ...]
    rest: Gap


def read_lines(file: SourceFile, tokens: Sequence[Token]) -> FileLines:
    """Find the logical lines of a file without errors.

    Args:
        file: The file.
        tokens: Its tokens.
    """
    lines: list[LogicalLine] = []
    end = 0  # end of the previous line
    columns: tuple[int, ...] = (0,)
    above = columns
    current: list[Token] = []
    for index, token in enumerate(tokens):
        match token.kind:
            case "_INDENT":
                columns = (*columns, token.value)
            case "_DEDENT":
                columns = columns[:-1]
            case "_NEWLINE":
                ends = [*(following.start for following in current[1:]), token.start]
                gaps = tuple(read_gap(file, one.end, behind) for one, behind in zip(current, ends, strict=True))
                before = read_gap(file, end, current[0].start)
                opens = tokens[index + 1].kind == "_INDENT"
                lines.append(
                    LogicalLine(before, len(columns) - 1, columns[-1], above, tuple(current), gaps, opens)
                )
                current, end, above = [], token.start, columns
            case "$END":
                pass
            case _:
                current.append(token)
    return FileLines(tuple(lines), above, read_gap(file, end, len(file.text)))


def read_gap(file: SourceFile, start: int, end: int) -> Gap:
    """Read a section of text without tokens."""
    comments: list[Comment] = []
    ends = 0  # line ends since the last comment
    has_end = False
    at_start = start == 0
    for found in _GAP.finditer(file.text, start, end):
        if found.lastgroup == "end":
            ends += 1
            has_end = at_start = True
        elif found.lastgroup == "joined":
            has_end = True
        elif found.lastgroup == "comment":
            is_blank = ends > 1 if comments or start else ends > 0
            comments.append(Comment(_tidy(found.group()), _column(file, found.start()), at_start, is_blank))
            ends = 0
    return Gap(tuple(comments), has_end, ends > 1 if comments or start else ends > 0)


def _column(file: SourceFile, offset: int) -> int:
    """Return the column of an offset, from 0."""
    start = offset - file.position(offset)[1] + 1
    return len(file.text[start:offset].replace("\f", "").expandtabs(TAB_STOP))


def _tidy(comment: str) -> str:
    """Return a comment without blanks at its end, and with one after its `#` (9.2.2.4)."""
    comment = comment.rstrip()
    return comment if _UNTOUCHED.match(comment) else f"# {comment[1:]}"
