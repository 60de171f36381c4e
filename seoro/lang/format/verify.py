"""Check that formatting changes only the layout, against defects of the formatter."""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.format.lines import read_gap
from seoro.lang.lexer import LAYOUT, Lexer
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile


def is_same(before: SourceFile, tree: ast.OscFile, after: SourceFile) -> bool:
    """Return whether another text has the same tree, except for spans, and the same comments.

    Args:
        before: The one text.
        tree: Its tree.
        after: The other text.
    """
    bag = Bag()
    other = parse_file(after, bag)
    return not len(bag) and _are_equal(tree, other) and _comments(before) == _comments(after)


def _are_equal(one: ast.OscFile, other: ast.OscFile) -> bool:
    """Return whether two trees are equal except for spans; without recursion, since trees may be deep."""
    pending: list[tuple[object, object]] = [(one, other)]
    while pending:
        left, right = pending.pop()
        if type(left) is not type(right):
            return False
        if isinstance(left, ast.Node):
            fields: tuple[str, ...] = left.__match_args__
            pending += [(getattr(left, name), getattr(right, name)) for name in fields if name != "span"]
        elif isinstance(left, tuple) and isinstance(right, tuple):
            if len(left) != len(right):
                return False
            pending += zip(left, right, strict=True)
        elif repr(left) != repr(right):  # unlike `==`, 0.0 and -0.0 differ, and nan is equal to nan
            return False
    return True


def _comments(file: SourceFile) -> list[str]:
    """Return the texts of all comments, sorted, since breaking brackets may reorder them."""
    tokens = [token for token in Lexer(file, Bag()).tokens() if token.kind not in LAYOUT]
    starts = [*(token.start for token in tokens), len(file.text)]
    ends = [0, *(token.end for token in tokens)]
    gaps = [read_gap(file, end, start) for end, start in zip(ends, starts, strict=True)]
    return sorted(comment.text for gap in gaps for comment in gap.comments)
