"""The automaton of the LALR(1) table: its stacks, and what shifting a token and reducing by a rule do to them.

What stands for a symbol is made by a method of `build.py`, called with its span and its children.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, NamedTuple

from seoro.lang import ast, table
from seoro.lang.build import Builder
from seoro.lang.diagnostics import syntax
from seoro.lang.lexer import Refused, Token
from seoro.lang.source import SourceFile, Span

MAX_FRAMES = 850  # of Python, whose limit is 1000, that those who walk over an expression may need for its depth
MAX_COMPOSITIONS = 512  # within each other; for more than Python's limit has room for, that is raised
_SPARE_FRAMES = 300  # for what calls those who walk over trees
LAYOUT = frozenset({"_NEWLINE", "_INDENT", "_DEDENT"})

_CHAINS = frozenset({"implication", "disjunction", "conjunction", "relation", "sum", "term"})
_FRAMES = {
    **dict.fromkeys(_CHAINS, 4),
    **dict.fromkeys(("ternary_op_exp", "inversion", "negation", "cast_exp", "type_test_exp"), 4),
    **dict.fromkeys(("element_access", "field_access", "list_constructor", "range_constructor"), 4),
    **dict.fromkeys(("list_type_declarator", "range_type_declarator"), 4),
    "function_application": 10,
    "composition": 7,
}  # that checking, lowering or running take for a level; a chain of operators of one kind is one level


_CHAINS_OF_UNITS: dict[tuple[int, int, str], int] = {}  # of the one table that there is


def _make_room(node: Any, depth: int, frames: int, span: Span) -> None:
    """See to it that those who walk over a tree have the frames that they need.

    Python's limit is one of the process. It is raised when there is a tree that needs it, and never lowered, since
    another thread may be within such a tree; calls of Python take none of the stack of C.

    Raises:
        Refused: They would be too many.
    """
    if not isinstance(node, ast.Composition):
        raise Refused(syntax.TooNested(span, MAX_FRAMES // frames))
    if depth > MAX_COMPOSITIONS * frames + MAX_FRAMES:
        raise Refused(syntax.TooNested(span, MAX_COMPOSITIONS))
    sys.setrecursionlimit(max(sys.getrecursionlimit(), depth + _SPARE_FRAMES))


class _Rule(NamedTuple):
    """What a reduction does; see `table.Table`."""

    origin: str
    length: int
    pick: list[int | None]
    is_list: bool
    is_spliced: bool  # or reuses a list: what is picked is more than single children
    callback: Callable[..., Any] | None  # None if the only child stands for the node
    frames: int  # that walking over what it makes takes
    is_chain: bool


class Automaton:
    """The stacks of one parse.

    Args:
        loaded: The table.
        file: The file that is parsed.
        builder: Makes the nodes of the tree.
    """

    def __init__(self, loaded: table.Table, file: SourceFile, builder: Builder) -> None:
        self.file = file
        self._rows = [loaded["rows"][number] for number in loaded["actions"]]
        self._gotos = loaded["gotos"]
        self._rules = [_rule(builder, *described) for described in loaded["rules"]]
        self._units = [
            origin if length == 1 and kind == "only" and pick == [0] else None
            for origin, length, pick, kind, _ in loaded["rules"]
        ]  # rules of one thing that stands for another: most of the work
        self._starts = loaded["starts"]
        self._chains = _CHAINS_OF_UNITS
        self._states: list[int] = []
        self._values: list[Any] = []
        self._spans: list[tuple[int, int, int]] = []  # start, end, and the frames for the depth of the tree
        self._marks: list[int] = []  # depth of the stack at the start of the current line of each open block
        self._fresh = True  # the next token is the first one of its line

    def _shift(self, state: int, token: Token, kind: str) -> None:
        if kind in LAYOUT:
            self._fresh = True
            if kind == "_DEDENT":
                self._marks.pop()
            elif kind == "_INDENT":
                self._marks.append(len(self._states))
        elif self._fresh:
            self._fresh = False
            if self._marks:
                self._marks[-1] = len(self._states)
            else:
                self._marks.append(len(self._states))
        self._states.append(state)
        self._values.append(token)
        self._spans.append((token.start, token.end, 0))

    def _reduce(self, number: int) -> None:
        origin, length, pick, is_list, is_spliced, callback, frames, is_chain = self._rules[number]
        states, values, spans = self._states, self._values, self._spans
        base = len(values) - length
        if is_spliced:
            children = _children(values, base, pick, is_list)
        else:
            children = [None if which is None else values[base + which] for which in pick]
        if length == 1:
            start, end, depth = spans.pop()
            del states[base], values[base]
        elif length:
            below = spans[base:]
            start, end, depth = below[0][0], below[-1][1], max([each[2] for each in below])
            del states[base:], values[base:], spans[base:]
        else:
            start = end = spans[-1][1]
            depth = 0
        if is_list:
            value: Any = children
        elif callback is None:
            value = children[0]
        else:
            span = Span(self.file, start, end)
            value = callback(span, *children)
            if frames:
                if is_chain and type(children[0]) is type(value):
                    depth = max(below[0][2], below[-1][2] + frames)
                else:
                    depth += frames
                if depth > MAX_FRAMES:
                    _make_room(value, depth, frames, span)
        states.append(self._gotos[states[-1]][origin])
        values.append(value)
        spans.append((start, end, depth))

    def _after_units(self, kind: str) -> int:
        """The state after all reductions by rules of one thing that a terminal brings about one after another.

        They replace the top of the stack only, so that it and the state below it tell where they lead. An operand
        is a sum, a relation, a conjunction and so on: without the table this is most of the work of a parse.
        """
        below, state = self._states[-2], self._states[-1]
        key = below, state, kind
        found = self._chains.get(key)
        if found is None:
            action: int | None = -1
            while action is not None and action < 0:
                action = self._rows[state].get(kind)
                origin = self._units[-1 - action] if action is not None and action < 0 else None
                if origin is None:
                    break
                state = self._gotos[below][origin]
            found = self._chains[key] = state
        return found

    def _accepts(self, terminal: str, depth: int | None = None) -> bool:
        """Whether a terminal can follow: the row alone may promise more (LALR), so the reductions are tried.

        Args:
            terminal: The terminal.
            depth: How much of the stack counts; all of it unless given.
        """
        states = self._states[:depth]
        while True:
            action = self._rows[states[-1]].get(terminal)
            if action is None:
                return False
            if action >= 0:
                return True
            rule = self._rules[-1 - action]
            if rule.length:
                del states[-rule.length :]
            states.append(self._gotos[states[-1]][rule.origin])

    def _truncate(self, depth: int) -> None:
        del self._states[depth:], self._values[depth:], self._spans[depth:]


def _rule(builder: Builder, origin: str, length: int, pick: list[int | None], kind: str, callback: str) -> _Rule:
    """A rule of the table with what it does."""
    is_list = kind == "list"
    is_spliced = any(which is not None and which >= table.SPLICED for which in pick)
    makes_node = not is_list and not (kind == "only" and len(pick) == 1)
    return _Rule(
        origin,
        length,
        pick,
        is_list,
        is_spliced,
        getattr(builder, callback) if makes_node else None,
        _FRAMES.get(callback, 0) if makes_node else 0,
        makes_node and callback in _CHAINS,
    )


def _children(values: list[Any], base: int, pick: list[int | None], is_list: bool) -> list[Any]:
    """What of a rule's symbols reaches the tree; a list that grows at its end is reused."""
    children: list[Any] = []
    for number, which in enumerate(pick):
        if which is None:
            children.append(None)
        elif which < table.SPLICED:
            children.append(values[base + which])
        elif number == 0 and is_list:
            children = values[base + which - table.SPLICED]
        else:
            children += values[base + which - table.SPLICED]
    return children
