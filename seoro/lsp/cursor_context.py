"""Context of the cursor: the enclosing type, its namespace, and the visible names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from seoro.lang import ast, plan, symbols
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.labels import labelled
from seoro.lang.check.scopes import Scope, running_scope, scope_of
from seoro.lang.diagnostic import Bag
from seoro.lang.namespaces import GLOBAL_NAMESPACE, Home, Space
from seoro.lang.parser import parse_expression
from seoro.lang.program import Declaration, Program
from seoro.lang.source import SourceFile
from seoro.lang.types import UNKNOWN
from seoro.lsp.analysis import Analysis
from seoro.lsp.cursor import Cursor
from seoro.lsp.regions import behavior_start

Callable_ = symbols.TypeSymbol | symbols.MethodSymbol | symbols.EventSymbol
_NAMESPACE = re.compile(r"^namespace[ \t]+(\w+)(?:[ \t]+use[ \t]+([^\r\n#]*))?", re.MULTILINE)
_BULK = frozenset(operator.value for operator in plan.Bulk)


@dataclass(frozen=True)
class CursorContext:
    """Context of the cursor.

    Args:
        cursor: The cursor.
        program: Declarations of the last check, which may be older than the text.
        space: The namespace of the text.
        owner: The type whose declaration or extension contains the cursor.
    """

    cursor: Cursor
    program: Program
    space: Space
    owner: symbols.TypeSymbol | None

    @cached_property
    def _expressions(self) -> Expressions:
        return Expressions(self.program, Bag(), strict=False)

    @cached_property
    def scope(self) -> Scope:
        """Scope of expressions at the cursor."""
        home = Home(self.space, None)
        scope = running_scope(self.owner, home) if self.owner is not None else scope_of(None, home)
        words = self.cursor.line.words
        bindings = dict(scope.bindings)
        if words[0] == "def" and len(words) > 1 and self.owner is not None:
            method = next((found for found in self.owner.methods.values() if found.text == words[1]), None)
            parameters = method.parameters if method is not None else {}
            bindings |= {parameter.text: parameter.type for parameter in parameters.values()}
        for index, word in enumerate(words[:-1]):
            if word == "as" and "@" in words and words.index("@") == index - 2:
                event = self.find_event(words[index - 1])
                if event is not None:
                    bindings[words[index + 1]] = symbols.EventObject(event)
        return self._within_operators(replace(scope, bindings=bindings))

    def find_event(self, text: str) -> symbols.EventSymbol | None:
        """Find an event of the enclosing type."""
        events = self.owner.inventory.events.with_text(text) if self.owner is not None else {}
        return next(iter(events.values()), None)

    def _within_operators(self, scope: Scope) -> Scope:
        """Return the scope with `it` of the innermost `filter` and the like."""
        for bracket in self.cursor.brackets:
            if bracket.is_call and self.cursor.line.words[bracket.index - 1] in _BULK:
                first = self.cursor.receiver(bracket.index)
                base = self._value(self.cursor.text(first, bracket.index - 2), scope)
                if isinstance(base, symbols.ListOf):
                    scope = replace(scope, it=base.element, is_it_bound=True)
        return scope

    def type_of(self, text: str) -> symbols.Type:
        """Return the type of an expression at the cursor."""
        return self._value(text, self.scope)

    def _value(self, text: str, scope: Scope) -> symbols.Type:
        node = parse_expression(SourceFile("cursor", text), Bag())
        return UNKNOWN if node is None else self._expressions.labels.receiver(node, scope).type

    @cached_property
    def labels(self) -> Mapping[str, ast.DoMember]:
        """Labelled behaviors in the enclosing scenario."""
        found = self.owner.do if self.owner is not None else None
        return {} if found is None else {name.text: member for name, member in labelled(found.directive.member)}

    # ------------------------------------------------------------ names

    def find_type(self, text: str) -> Declaration | None:
        """Find a type."""
        name = name_in(text)
        return self._expressions.lookup.type(self.space, name) if name is not None else None

    def find_behavior(self, text: str, actor: symbols.TypeSymbol | None) -> symbols.TypeSymbol | None:
        """Find a scenario, action or modifier of an actor, or of none."""
        name, lookup = name_in(text), self._expressions.lookup
        if name is None:
            return None
        return lookup.behavior(self.space, actor, name) or lookup.modifier(self.space, actor, name)

    def find_method(self, text: str, owner: symbols.TypeSymbol | None) -> symbols.MethodSymbol | None:
        """Find a method of a type."""
        name = name_in(text)
        if name is None or owner is None:
            return None
        return self._expressions.lookup.member(self.space, owner.inventory.methods, name)

    def shown(self, symbol: Declaration | symbols.TypeSymbol, found: Declaration | None) -> str:
        """Return the name of a symbol here, given the meaning of its bare name."""
        return symbol.name if found is symbol else f"{symbol.namespace}::{symbol.name}"

    def types(self) -> Iterator[tuple[str, Declaration]]:
        """Yield all types, with their names here."""
        for symbol in self.program.types.values():
            yield self.shown(symbol, self.find_type(symbol.name)), symbol

    def behaviors(self, table: Iterable[symbols.TypeSymbol]) -> Iterator[tuple[str, symbols.TypeSymbol]]:
        """Yield scenarios, actions or modifiers, with their names here."""
        for symbol in table:
            yield self.shown(symbol, self.find_behavior(symbol.name, symbol.actor)), symbol


def cursor_context(cursor: Cursor, analyses: Sequence[Analysis]) -> CursorContext:
    """Create the context of the cursor from the first analysis that knows the enclosing type.

    Args:
        cursor: The cursor.
        analyses: Analyses of the document, newest first; at least one.
    """
    owners = ((analysis, owner) for analysis in analyses if (owner := _owner(cursor, analysis)) is not None)
    analysis, owner = next(owners, (analyses[0], None))
    return CursorContext(cursor, analysis.checked.program, _space(cursor, analysis), owner)


def _owner(cursor: Cursor, analysis: Analysis) -> symbols.TypeSymbol | None:
    """Return the type that the outermost line declares or extends."""
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
    """Return the namespace of the last namespace statement before the cursor."""
    found = _NAMESPACE.findall(cursor.file.text)
    if not found:
        return Space(GLOBAL_NAMESPACE, analysis.checked.sources.uses)
    name, uses = found[-1]
    return Space(name, frozenset(used.strip() for used in uses.split(",") if used.strip()))


def name_in(text: str) -> ast.Name | None:
    """Parse a name; None for other texts."""
    node = parse_expression(SourceFile("cursor", text), Bag())
    return node.name if isinstance(node, ast.NameExpression) else None


def callee(around: CursorContext) -> Callable_ | None:
    """Return the callee of the innermost bracket around the cursor; None without a call, or if it is unknown."""
    cursor = around.cursor
    if not cursor.brackets or not cursor.brackets[-1].is_call:
        return None
    index = cursor.brackets[-1].index
    first = cursor.receiver(index)
    name = cursor.text(index - 1, index)
    is_behavior = first == behavior_start(cursor)
    if index - 1 == first:
        if first and cursor.line.words[first - 1] == "emit" and around.owner is not None:
            return around.find_event(name)
        return _unprefixed(around, name, is_behavior)
    base = around.type_of(cursor.text(first, index - 2))
    owner = base.symbol if isinstance(base, symbols.Structured) else None
    return around.find_behavior(name, owner) if is_behavior else around.find_method(name, owner)


def _unprefixed(around: CursorContext, name: str, is_behavior: bool) -> Callable_ | None:
    if is_behavior:
        own = around.owner.actor if around.owner is not None else None
        found = around.find_behavior(name, own) if own is not None else None
        return found or around.find_behavior(name, None)
    symbol = around.find_type(name)
    return symbol if isinstance(symbol, symbols.TypeSymbol) else around.find_method(name, around.owner)
