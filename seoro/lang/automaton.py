"""LALR(1) automaton: its stacks, and the operations shift and reduce.

For each reduction, a callback of `build.py` creates the node from its span and its children.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from seoro.lang import ast, parse_table
from seoro.lang.build import Builder, callback_of
from seoro.lang.diagnostics import syntax
from seoro.lang.lexer import LAYOUT, Refused, Token
from seoro.lang.source import SourceFile, Span

MAX_FRAMES = 850  # Python frames for a traversal of an expression; Python's limit is 1000
MAX_COMPOSITIONS = 512  # nested; Python's limit is raised if necessary
_SPARE_FRAMES = 300  # for the callers of traversals

_CHAINS = {  # chained operators, each with the symbol of its rule that continues a chain
    **dict.fromkeys(("implication", "disjunction", "conjunction", "relation", "sum", "term"), 0),
    "ternary_op_exp": -1,
}
_FRAMES = {
    **dict.fromkeys(_CHAINS, 4),
    **dict.fromkeys(("inversion", "negation", "cast_exp", "type_test_exp"), 4),
    **dict.fromkeys(("element_access", "field_access", "list_constructor", "range_constructor"), 4),
    **dict.fromkeys(("list_type_declarator", "range_type_declarator"), 4),
    "function_application": 10,
    "composition": 7,
}  # frames per level for checking, lowering or running; a chain of one kind of operators is one level


_CHAINS_OF_UNITS: dict[tuple[int, int, str], int] = {}  # of the only table


def _make_room(node: Any, depth: int, frames: int, span: Span) -> None:
    """Ensure that traversals of a tree have enough Python frames.

    Python's recursion limit belongs to the process. It is raised for deep trees, and never lowered, since another
    thread may traverse such a tree. Python calls use no C stack.

    Raises:
        Refused: The tree needs too many frames.
    """
    start = Span(span.file, span.start, span.start + 1)
    if not isinstance(node, ast.Composition):
        raise Refused(syntax.too_nested(start, MAX_FRAMES // frames))
    if depth > MAX_COMPOSITIONS * frames + MAX_FRAMES:
        raise Refused(syntax.too_nested(start, MAX_COMPOSITIONS))
    sys.setrecursionlimit(max(sys.getrecursionlimit(), depth + _SPARE_FRAMES))


class _Rule(NamedTuple):
    """A reduction; see `parse_table.Table`."""

    origin: str
    length: int
    pick: list[int | None]
    is_list: bool
    is_spliced: bool  # or reuses a list: picks more than single children
    callback: Callable[..., Any] | None  # None if the only child stands for the node
    frames: int  # for a traversal of its node
    chain: int | None  # the symbol that continues a chain of such operators, or None


class _Program(NamedTuple):
    """The parse table, as all parses of the process use it."""

    rows: list[dict[str, int]]  # of each state
    rules: list[_Rule]
    units: list[str | None]  # origins of unit rules, which are most of the work


@cache
def _program() -> _Program:
    loaded = parse_table.load()
    return _Program(
        [loaded["rows"][number] for number in loaded["actions"]],
        [_rule(*described) for described in loaded["rules"]],
        [
            origin if length == 1 and kind == "only" and pick == [0] else None
            for origin, length, pick, kind, _ in loaded["rules"]
        ],
    )


class Automaton:
    """The stacks of one parse.

    Args:
        file: The parsed file.
        builder: Builder of the tree.
    """

    def __init__(self, file: SourceFile, builder: Builder) -> None:
        self.file = file
        self._builder = builder
        loaded = parse_table.load()
        self._rows, self._rules, self._units = _program()
        self._gotos = loaded["gotos"]
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
        origin, length, pick, is_list, is_spliced, callback, frames, chain = self._rules[number]
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
            value = callback(self._builder, span, *children)
            if frames:
                if chain is not None and type(children[chain]) is type(value):
                    row = below[chain][2]
                    below[chain] = below[chain][0], below[chain][1], 0
                    depth = max(row, max([each[2] for each in below]) + frames)
                else:
                    depth += frames
                if depth > MAX_FRAMES:
                    _make_room(value, depth, frames, span)
        states.append(self._gotos[states[-1]][origin])
        values.append(value)
        spans.append((start, end, depth))

    def _after_units(self, kind: str) -> int:
        """Return the state after all consecutive reductions by unit rules for a terminal.

        They replace only the top of the stack, so the result depends only on it and the state below. An operand is
        a sum, a relation, a conjunction and so on: without the cache, this is most of the work of a parse.
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
        """Return whether a terminal can follow; LALR rows may accept too much, so the reductions are simulated.

        Args:
            terminal: The terminal.
            depth: Height of the stack to use; default all.
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


def _rule(origin: str, length: int, pick: list[int | None], kind: str, callback: str) -> _Rule:
    """Create the reduction of a rule of the table."""
    is_list = kind == "list"
    is_spliced = any(which is not None and which >= parse_table.SPLICED for which in pick)
    makes_node = not is_list and not (kind == "only" and len(pick) == 1)
    return _Rule(
        origin,
        length,
        pick,
        is_list,
        is_spliced,
        callback_of(callback) if makes_node else None,
        _FRAMES.get(callback, 0) if makes_node else 0,
        _CHAINS.get(callback) if makes_node else None,
    )


def _children(values: list[Any], base: int, pick: list[int | None], is_list: bool) -> list[Any]:
    """Select the values of a rule's symbols for the tree; a list that grows at its end is reused."""
    children: list[Any] = []
    for number, which in enumerate(pick):
        if which is None:
            children.append(None)
        elif which < parse_table.SPLICED:
            children.append(values[base + which])
        elif number == 0 and is_list:
            children = values[base + which - parse_table.SPLICED]
        else:
            children += values[base + which - parse_table.SPLICED]
    return children
