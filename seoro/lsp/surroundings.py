"""What names mean around the cursor: the type that is being written, its namespace, and what it can name there."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from seoro.lang import ast, plan
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.labels import Labels, labelled
from seoro.lang.check.scopes import Scope, scope_of
from seoro.lang.diagnostic import Bag
from seoro.lang.parser import parse_expression
from seoro.lang.source import SourceFile
from seoro.lang.symbols import (
    GLOBAL_NAMESPACE,
    Declaration,
    EventSymbol,
    Home,
    MethodSymbol,
    Program,
    Space,
    TypeSymbol,
    all_events,
    all_methods,
    do_directive,
)
from seoro.lang.types import UNKNOWN, EventObject, ListOf, Structured, Type
from seoro.lsp.analysis import Analysis
from seoro.lsp.cursor import Cursor, Line

Callable_ = TypeSymbol | MethodSymbol | EventSymbol
_NAMESPACE = re.compile(r"^namespace[ \t]+(\w+)(?:[ \t]+use[ \t]+([^\r\n#]*))?", re.MULTILINE)
_BULK = frozenset(operator.value for operator in plan.Bulk)


@dataclass(frozen=True)
class Surroundings:
    """What is known where the cursor stands.

    Args:
        cursor: The cursor.
        program: What is declared; as of the last check, which may be older than the text.
        space: The namespace of the text.
        owner: The type that is being written, or extended.
    """

    cursor: Cursor
    program: Program
    space: Space
    owner: TypeSymbol | None

    @cached_property
    def _expressions(self) -> Expressions:
        return Expressions(self.program, Bag(), strict=False)

    @cached_property
    def scope(self) -> Scope:
        """What expressions at the cursor can name."""
        scope = scope_of(self.owner, Home(self.space, None))
        if self.owner is not None:
            scope = replace(scope, labels=Labels(self.owner, self._expressions))
        words, line = self.cursor.line.words, self.cursor.line
        if words[0] == "def" and len(words) > 1 and self.owner is not None:
            method = next((found for found in self.owner.methods.values() if found.text == words[1]), None)
            parameters = method.parameters if method is not None else {}
            bindings = {parameter.text: parameter.type for parameter in parameters.values()}
            scope = replace(scope, bindings={**scope.bindings, **bindings})
        for index, word in enumerate(words[:-1]):
            if word == "as" and "@" in words[:index]:
                event = self._event(line, words.index("@") + 1, index)
                if event is not None:
                    scope = replace(scope, bindings={**scope.bindings, words[index + 1]: EventObject(event)})
        return self._within_operators(scope)

    def _event(self, line: Line, first: int, end: int) -> EventSymbol | None:
        """The event of the scenario itself that some tokens name."""
        if self.owner is None or end - first != 1:
            return None
        return next((found for found in all_events(self.owner).values() if found.text == line.word(first)), None)

    def _within_operators(self, scope: Scope) -> Scope:
        """With `it` as it is in the argument of `filter` and the like."""
        for bracket in self.cursor.brackets:
            if bracket.is_call and self.cursor.line.word(bracket.index - 1) in _BULK:
                first = self.cursor.receiver(bracket.index)
                base = self._value(self.cursor.text(first, bracket.index - 2), scope)
                if isinstance(base, ListOf):
                    scope = replace(scope, it=base.element, is_it_bound=True)
        return scope

    def type_of(self, text: str) -> Type:
        """The type of an expression that stands at the cursor."""
        return self._value(text, self.scope)

    def _value(self, text: str, scope: Scope) -> Type:
        node = parse_expression(SourceFile("cursor", text), Bag())
        return UNKNOWN if node is None else self._expressions.holders.find(node, scope).type

    @cached_property
    def labels(self) -> Mapping[str, ast.DoMember]:
        """The behaviors with labels in the scenario that is being written."""
        found = do_directive(self.owner) if self.owner is not None else None
        return {} if found is None else {name.text: member for name, member in labelled(found.directive.member)}

    # ------------------------------------------------------------ names

    def find_type(self, text: str) -> Declaration | None:
        """The type that a name means."""
        name = name_in(text)
        return self._expressions.lookup.type(self.space, name) if name is not None else None

    def find_behavior(self, text: str, actor: TypeSymbol | None) -> TypeSymbol | None:
        """The scenario, action or modifier of an actor, or of none, that a name means."""
        name, lookup = name_in(text), self._expressions.lookup
        if name is None:
            return None
        return lookup.behavior(self.space, actor, name) or lookup.modifier(self.space, actor, name)

    def find_method(self, text: str, owner: TypeSymbol | None) -> MethodSymbol | None:
        """The method of a type that a name means."""
        name = name_in(text)
        if name is None or owner is None:
            return None
        return self._expressions.lookup.member(self.space, all_methods(owner), name)

    def shown(self, symbol: Declaration | TypeSymbol, found: Declaration | None) -> str:
        """How to name a symbol here, given what its bare name means."""
        return symbol.name if found is symbol else f"{symbol.namespace}::{symbol.name}"

    def types(self) -> Iterator[tuple[str, Declaration]]:
        """All types, and how to name them here."""
        for symbol in self.program.types.values():
            yield self.shown(symbol, self.find_type(symbol.name)), symbol

    def behaviors(self, table: Iterable[TypeSymbol]) -> Iterator[tuple[str, TypeSymbol]]:
        """Some scenarios, actions or modifiers, and how to name them here."""
        for symbol in table:
            yield self.shown(symbol, self.find_behavior(symbol.name, symbol.actor)), symbol


def surroundings(cursor: Cursor, analyses: Iterable[Analysis]) -> Surroundings:
    """What is known where the cursor stands, from the first analysis that knows the type that is being written.

    Args:
        cursor: The cursor.
        analyses: Of the document, the newest first; at least one.
    """
    found = list(analyses)
    for analysis in found:
        owner = _owner(cursor, analysis)
        if owner is not None:
            return Surroundings(cursor, analysis.checked.program, _space(cursor, analysis), owner)
    return Surroundings(cursor, found[0].checked.program, _space(cursor, found[0]), None)


def _owner(cursor: Cursor, analysis: Analysis) -> TypeSymbol | None:
    """The type that the outermost line declares or extends."""
    words = (cursor.parents[-1] if cursor.parents else cursor.line).words
    if len(words) < 2 or words[0] not in {"struct", "actor", "scenario", "action", "modifier", "extend"}:
        return None
    actor, name = (words[1], words[3]) if len(words) > 3 and words[2] == "." else (None, words[1])
    name = name.rpartition("::")[2]
    found = [
        symbol
        for symbol in analysis.checked.program.structured()
        if symbol.name == name
        and (symbol.actor.name if symbol.actor is not None else None) == actor
        and words[0] in {symbol.kind.value, "extend"}
    ]
    here = [symbol for symbol in found if symbol.span.file is analysis.file]
    return next(iter(here or found), None)


def _space(cursor: Cursor, analysis: Analysis) -> Space:
    """What the last namespace statement before the cursor says."""
    found = _NAMESPACE.findall(cursor.file.text)
    if not found:
        return Space(GLOBAL_NAMESPACE, analysis.checked.sources.uses)
    name, uses = found[-1]
    return Space(name, frozenset(used.strip() for used in uses.split(",") if used.strip()))


def name_in(text: str) -> ast.Name | None:
    """A text as a name; None if it is none."""
    node = parse_expression(SourceFile("cursor", text), Bag())
    return node.name if isinstance(node, ast.NameExpression) else None


def callee(around: Surroundings, index: int, starts: int | None) -> Callable_ | None:
    """What the arguments in a bracket are given to; None if it is not known.

    Args:
        around: What is known.
        index: Of the bracket's token in the line.
        starts: The index at which a behavior may begin in the line; None if none may.
    """
    cursor = around.cursor
    first = cursor.receiver(index)
    name = cursor.text(index - 1, index)
    words = cursor.line.words
    is_behavior = starts is not None and first == starts
    if index - 1 == first:
        if first and words[first - 1] == "emit" and around.owner is not None:
            return next((event for event in all_events(around.owner).values() if event.text == name), None)
        return _unprefixed(around, name, is_behavior)
    base = around.type_of(cursor.text(first, index - 2))
    owner = base.symbol if isinstance(base, Structured) else None
    return around.find_behavior(name, owner) if is_behavior else around.find_method(name, owner)


def _unprefixed(around: Surroundings, name: str, is_behavior: bool) -> Callable_ | None:
    if is_behavior:
        own = around.owner.actor if around.owner is not None else None
        found = around.find_behavior(name, own) if own is not None else None
        return found or around.find_behavior(name, None)
    symbol = around.find_type(name)
    return symbol if isinstance(symbol, TypeSymbol) else around.find_method(name, around.owner)
