"""Incremental parser: after an edit, unchanged statements keep their trees.

A text is cut where lines begin in the first column. A piece without errors leaves the parser in its initial state,
so the next piece can be parsed separately. A piece with errors is parsed together with the next one, since
recovery may skip text of it. If an error reaches beyond that, the whole text is parsed.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

from seoro.lang import ast
from seoro.lang.build import Builder
from seoro.lang.diagnostic import Bag
from seoro.lang.habits import foreign_format
from seoro.lang.lexer import MAX_ERRORS
from seoro.lang.parser import parse_file, parse_part
from seoro.lang.source import SourceFile, Span
from seoro.lang.tree_copy import is_deep, moved

MAX_CHANGED: Final = 30  # pieces that are parsed one by one; with more, the whole text is parsed
_START: Final = re.compile(r"(?:\A|(?<=\n)(?<!\\\n)(?<!\\\r\n)|(?<=\r)(?<!\\\r)(?!\n))[^\s#]")
_TRIVIA: Final = re.compile(r"(?:[ \t\f]*(?:#[^\r\n]*)?[\r\n]+)*")


class _Piece(NamedTuple):
    """A part of a text without errors.

    Args:
        statements: Its trees.
        start: Its start in the parsed text.
        end: End of its last token; used for the last piece of a text.
        is_moved: Whether its trees are copies, which are never deep.
    """

    statements: tuple[ast.Statement, ...]
    start: int
    end: int
    is_moved: bool = False


class IncrementalParser:
    """Parses successive versions of one text, each with the trees of the version before."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, bool], _Piece] = {}  # by text, and whether it is the last piece

    def parse(self, file: SourceFile, bag: Bag) -> ast.OscFile:
        """Parse a whole file; errors go to the bag. Equals `parse_file`."""
        starts = [found.start() for found in _START.finditer(file.text)]
        found = self._from_pieces(file, bag, starts)
        if found is not None:
            Builder(file, bag).osc_file(found.span, *found.statements)  # reports misplaced imports
            return found
        before = len(bag)
        tree = parse_file(file, bag)
        if len(bag) == before:
            self._learn(tree, starts)
        return tree

    def _learn(self, tree: ast.OscFile, starts: list[int]) -> None:
        """Store the trees of a text without errors; starts within strings or brackets have no statement."""
        text = tree.span.file.text
        at: dict[int, list[ast.Statement]] = {}
        for statement in tree.statements:
            at.setdefault(starts[bisect_right(starts, statement.span.start) - 1], []).append(statement)
        self._known = {
            (text[start:stop], stop == len(text)): _Piece(tuple(at[start]), start, tree.span.end)
            for start, stop in pairwise([*at, len(text)])
            if not any(map(is_deep, at[start]))
        }

    def _from_pieces(self, file: SourceFile, bag: Bag, starts: list[int]) -> ast.OscFile | None:
        """Parse the changed pieces; None if the whole text must be parsed."""
        text = file.text
        if not self._known or not starts or not _TRIVIA.fullmatch(text, 0, starts[0]) or foreign_format(text):
            return None
        places = list(pairwise([*starts, len(text)]))
        pieces = self._pieces(file, places)
        if pieces is None:
            return None
        parts = [
            ast.OscFile(piece.statements, (), Span(file, piece.start, piece.end)) for piece in pieces if piece
        ]
        broken = [number for number, piece in enumerate(pieces) if piece is None]
        if broken:
            part = _parse_broken(file, bag, places, pieces, broken)
            if part is None:
                return None
            parts.insert(broken[0], part)
        self._known = {
            (text[start:stop], stop == len(text)): piece
            for (start, stop), piece in zip(places, pieces, strict=True)
            if piece is not None and (piece.is_moved or not any(map(is_deep, piece.statements)))
        }
        statements = tuple(statement for part in parts for statement in part.statements)
        unread = next((part.unread for part in parts if part.unread != ()), ())
        return ast.OscFile(statements, unread, Span(file, parts[0].span.start, parts[-1].span.end))

    def _pieces(self, file: SourceFile, places: Sequence[tuple[int, int]]) -> list[_Piece | None] | None:
        """Return the pieces, None for those with errors; None if too many have changed."""
        found: list[_Piece | None] = []
        changed = 0
        for start, stop in places:
            known = self._known.get((file.text[start:stop], stop == len(file.text)))
            if known is not None:
                found.append(_move(known, file, start))
                continue
            changed += 1
            if changed > MAX_CHANGED:
                return None
            found.append(_parse_piece(file, start, stop))
        return found


def _move(piece: _Piece, file: SourceFile, start: int) -> _Piece:
    """Copy the trees of a piece to its current place."""
    shift = start - piece.start
    statements = tuple([moved(statement, file, shift) for statement in piece.statements])
    return _Piece(statements, start, piece.end + shift, True)


def _parse_piece(file: SourceFile, start: int, stop: int) -> _Piece | None:
    """Parse a single piece; None if it has errors."""
    bag = Bag()
    tree = parse_part(file, bag, start, stop)
    return _Piece(tree.statements, start, tree.span.end) if tree is not None and len(bag) == 0 else None


def _parse_broken(
    file: SourceFile,
    bag: Bag,
    places: Sequence[tuple[int, int]],
    pieces: Sequence[_Piece | None],
    broken: Sequence[int],
) -> ast.OscFile | None:
    """Parse pieces with errors and the next one; None if an error may reach further."""
    first, behind = broken[0], broken[-1] + 1
    if behind - first != len(broken):
        return None
    own = Bag()
    following = pieces[behind] if behind < len(places) else None
    stop = places[behind][1] if following is not None else len(file.text)
    tree = parse_part(file, own, places[first][0], stop)
    if tree is None or len(own) >= MAX_ERRORS:
        return None
    statements = tree.statements
    if following is not None:
        count = len(statements) - len(following.statements)
        if [each.span for each in statements[count:]] != [each.span for each in following.statements]:
            return None
        if any(found.primary.span.end > following.start for found in own.diagnostics):
            return None
        statements = statements[:count]
    for found in own.diagnostics:
        bag.put(found)
    return ast.OscFile(statements, tree.unread, tree.span)
