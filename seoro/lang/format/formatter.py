"""Formats a file: puts its logical lines, with their comments and blank lines, one below the other."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from enum import Enum, auto

from seoro.errors import InvalidScenario
from seoro.lang.diagnostic import Bag
from seoro.lang.format.aligned import OutLine, align, take_continuation
from seoro.lang.format.elements import MAX_BRACKETS, deepest, read_elements
from seoro.lang.format.fault import LayoutFault
from seoro.lang.format.layout import INDENT, Place, lay_out
from seoro.lang.format.lines import Comment, FileLines, Gap, LogicalLine, read_lines
from seoro.lang.format.roles import find_names, find_roles
from seoro.lang.format.verify import is_same
from seoro.lang.lexer import Lexer, Token
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile, Span


def format_text(file: SourceFile) -> str:
    """The text of a file, formatted by the standard's coding style guide (9.2.2).

    The result has the same tree, and formatting it again changes nothing.

    Args:
        file: The file; nothing is read or written.

    Raises:
        InvalidScenario: The text has syntax errors.
        LayoutFault: Its brackets are nested too deeply, or the result would mean something else.
    """
    bag = Bag()
    tree = parse_file(file, bag)
    if len(bag):
        raise InvalidScenario(sorted(bag.diagnostics, key=lambda found: found.position))
    text = _write(file, read_lines(file, Lexer(file, bag).tokens()), find_names(tree))
    if not is_same(file, tree, SourceFile(file.name, text)):
        raise LayoutFault(f"formatting `{file.name}` would change what it says; it is left as it is")
    return text


class _Kind(Enum):
    """What blank lines between statements of the file itself depend on."""

    IMPORT = auto()
    LINE = auto()
    BLOCK = auto()


def _write(file: SourceFile, found: FileLines, names: Collection[int]) -> str:
    """The text of logical lines."""
    out: list[OutLine] = []
    is_header = True  # what was written last begins a block, or is nothing yet
    last: _Kind | None = None  # of the file's own statements
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
    """Whether a blank line belongs between two statements of a file: around blocks, and behind imports."""
    return before is not None and (_Kind.BLOCK in {before, after} or before is not after)


def _above(gap: Gap, columns: tuple[int, ...], level: int, is_apart: bool) -> Iterator[OutLine]:
    """The comments and blank lines above a line; never more than one blank line.

    Args:
        gap: What was there.
        columns: The columns of the blocks that were open.
        level: Of the line below.
        is_apart: Whether there has to be a blank line.
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
    """Comments with the levels that they belong to.

    Where blocks end, a comment belongs to the innermost one that it is indented for; once a comment has left a
    block, none goes back into it.
    """
    deepest = max(len(columns) - 1, level)
    for comment in comments:
        while deepest > level and (deepest >= len(columns) or columns[deepest] > comment.column):
            deepest -= 1
        yield comment, deepest


def _lay_out_line(file: SourceFile, line: LogicalLine, names: Collection[int]) -> list[OutLine]:
    """The lines of a logical line.

    Raises:
        LayoutFault: More than `MAX_BRACKETS` brackets stand in each other.
    """
    roles = find_roles(line.tokens, names)
    if deepest(roles) > MAX_BRACKETS:
        at = Span(file, line.tokens[0].start, line.tokens[0].end)
        raise LayoutFault(f"{at}: brackets that are nested more than {MAX_BRACKETS} deep cannot be laid out")
    elements = read_elements([_written(file, token) for token in line.tokens], roles, line.gaps)
    hang = 2 * INDENT if line.opens_block else INDENT
    *lines, last = lay_out(elements, Place(INDENT * line.level, hang, continued=hang, in_brackets=False))
    comments = line.gaps[-1].comments
    return [*map(OutLine, lines), OutLine(last, comments[0] if comments else None)]


def _written(file: SourceFile, token: Token) -> str:
    """A token as it is written, without the blanks that `namespace:: *` may have."""
    found = file.text[token.start : token.end]
    return found.replace(" ", "").replace("\t", "") if token.kind == "WILDCARD" else found
