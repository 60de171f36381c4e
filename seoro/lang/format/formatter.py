"""Formatting of a file: joins its formatted logical lines, comments and blank lines, and aligns comments."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from enum import Enum, auto
from itertools import groupby
from typing import NamedTuple

from seoro.errors import InvalidScenario, SeoroError
from seoro.lang.diagnostic import Bag
from seoro.lang.format.elements import MAX_BRACKETS, deepest, read_elements
from seoro.lang.format.layout import INDENT, Place, lay_out
from seoro.lang.format.lines import Comment, FileLines, Gap, LogicalLine, read_lines
from seoro.lang.format.roles import find_names, find_roles
from seoro.lang.format.verify import is_same
from seoro.lang.lexer import Lexer, Token
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile, Span


class LayoutFault(SeoroError):
    """A valid text cannot be formatted and stays unchanged."""


def format_text(file: SourceFile) -> str:
    """Format a file by the coding style guide of the standard (9.2.2).

    The result has the same tree, and formatting it again changes nothing.

    Args:
        file: The file; nothing is read or written.

    Raises:
        InvalidScenario: The text has syntax errors.
        LayoutFault: Its brackets are nested too deeply, or formatting would change the meaning.
    """
    bag = Bag()
    tree = parse_file(file, bag)
    if len(bag):
        raise InvalidScenario(sorted(bag.diagnostics, key=lambda found: found.position))
    text = _write(file, read_lines(file, Lexer(file, bag).tokens()), find_names(tree))
    if not is_same(file, tree, SourceFile(file.name, text)):
        raise LayoutFault(f"formatting `{file.name}` would change its meaning; the file is unchanged")
    return text


class _Kind(Enum):
    """Kind of a top-level statement, which determines blank lines around it."""

    IMPORT = auto()
    LINE = auto()
    BLOCK = auto()


def _write(file: SourceFile, found: FileLines, names: Collection[int]) -> str:
    """Write logical lines."""
    out: list[OutLine] = []
    is_header = True  # at the start of the file or of a block
    last: _Kind | None = None  # kind of the last top-level statement
    for line in found.lines:
        kind = _kind(line, names) if line.level == 0 else None
        above = take_continuation(out, line.before, line.column)
        lines = list(_above(above, line.columns, line.level, kind is not None and _is_apart(last, kind)))
        out += lines[1:] if is_header and lines and not lines[0].text else lines
        out += _lay_out_line(file, line, names)
        is_header = line.opens_block
        last = kind or last
    rest = take_continuation(out, found.rest, 0)._replace(ends_blank=False)
    lines = list(_above(rest, found.columns, 0, False))
    out += lines[1:] if is_header and lines and not lines[0].text else lines
    return "".join(f"{line}\n" for line in align(out))


def _kind(line: LogicalLine, names: Collection[int]) -> _Kind:
    first = line.tokens[0]
    if first.value == "import" and first.start not in names:
        return _Kind.IMPORT
    return _Kind.BLOCK if line.opens_block else _Kind.LINE


def _is_apart(before: _Kind | None, after: _Kind) -> bool:
    """Return whether a blank line separates two statements: around blocks, and after imports."""
    return before is not None and (_Kind.BLOCK in {before, after} or before is not after)


def _above(gap: Gap, columns: tuple[int, ...], level: int, is_apart: bool) -> Iterator[OutLine]:
    """Yield the comments and blank lines above a line, at most one blank line in a row.

    Args:
        gap: The comments and blank lines in the source.
        columns: Columns of the open blocks.
        level: Level of the line below.
        is_apart: Whether a blank line is necessary.
    """
    placed = list(_place(gap.comments, columns, level))
    missing = is_apart and not (
        gap.ends_blank or any(comment.after_blank for comment, depth in placed if depth == level)
    )
    for comment, depth in placed:
        if comment.after_blank or (missing and depth == level):
            yield OutLine("")
        missing = missing and depth != level
        yield OutLine(" " * (INDENT * depth) + comment.text)
    if gap.ends_blank or missing:
        yield OutLine("")


def _place(comments: tuple[Comment, ...], columns: tuple[int, ...], level: int) -> Iterator[tuple[Comment, int]]:
    """Yield comments with their levels.

    At the end of blocks, the indentation of a comment determines its block. Later comments cannot return to
    an inner block.
    """
    deepest = max(len(columns) - 1, level)
    for comment in comments:
        while deepest > level and (deepest >= len(columns) or columns[deepest] > comment.column):
            deepest -= 1
        yield comment, deepest


def _lay_out_line(file: SourceFile, line: LogicalLine, names: Collection[int]) -> list[OutLine]:
    """Format a logical line.

    Raises:
        LayoutFault: More than `MAX_BRACKETS` brackets are nested.
    """
    roles = find_roles(line.tokens, names)
    if deepest(roles) > MAX_BRACKETS:
        at = Span(file, line.tokens[0].start, line.tokens[0].end)
        raise LayoutFault(f"{at}: cannot format brackets nested more than {MAX_BRACKETS} deep")
    elements = read_elements([_written(file, token) for token in line.tokens], roles, line.gaps)
    hang = 2 * INDENT if line.opens_block else INDENT
    *lines, last = lay_out(elements, Place(INDENT * line.level, hang, continued=hang, in_brackets=False))
    comments = line.gaps[-1].comments
    return [*map(OutLine, lines), OutLine(last, comments[0] if comments else None)]


def _written(file: SourceFile, token: Token) -> str:
    """Return the source text of a token, without blanks in `namespace:: *`."""
    found = file.text[token.start : token.end]
    return found.replace(" ", "").replace("\t", "") if token.kind == "WILDCARD" else found


class OutLine(NamedTuple):
    """An output line: its text, which may be empty, and the comment after it."""

    text: str
    comment: Comment | None = None


def take_continuation(out: list[OutLine], gap: Gap, below: int) -> Gap:
    """Move comments directly below a comment after a statement to the output; return the rest of the gap.

    Args:
        out: The lines before the gap.
        gap: Comments and blank lines between two statements.
        below: The column of the statement below, to which comments at the same column belong.
    """
    taken = 0
    if out and (last := out[-1].comment) is not None:
        for comment in gap.comments:
            if comment.after_blank or comment.column != last.column or comment.column == below:
                break
            out.append(OutLine("", comment))
            taken += 1
    return gap._replace(comments=gap.comments[taken:])


def align(lines: list[OutLine]) -> Iterator[str]:
    """Yield the lines, with aligned comments two blanks after the longest statement among them."""
    for column, run in groupby(lines, key=lambda line: line.comment.column if line.comment else None):
        members = list(run)
        width = max(len(line.text.rsplit("\n", 1)[-1]) for line in members)
        for text, comment in members:
            if column is None or comment is None:
                yield text
            else:
                shown = len(text.rsplit("\n", 1)[-1])
                yield f"{text}{' ' * (width - shown + 2)}{comment.text}"
