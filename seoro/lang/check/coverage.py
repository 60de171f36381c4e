"""`cover` and `record` (7.5): the items of all types, each with its overrides in the order of the text.

Section 7.5 names structs, actors and scenarios. Actions and modifiers have the same members as scenarios
(7.3.5.1.4, 7.3.5.1.5, and the grammar), so they have items, too.

The name of an item is unique in its type and bases. An override changes an item of the same type, above it or in
an extension (7.5.6), and begins with the word of the item, `cover` or `record`. A disabled item is not sampled,
and neither are crosses that combine it with others.

Each draft is elaborated when it is declared and again with every override, so that overridden values must be
valid, too. Equal messages at the same place count once.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterator, Mapping
from dataclasses import replace

from seoro.lang import ast, plan
from seoro.lang.check.coverage_arguments import Argument, collect
from seoro.lang.check.coverage_items import Draft, Item, Items
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import Scope, running_scope
from seoro.lang.check.values import declared
from seoro.lang.diagnostics import coverage as messages
from seoro.lang.namespaces import Home
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol, TypeSymbol, lineage

_FIXED = ("name", "expression", "event", "unit")  # arguments that an override cannot change


class Coverage:
    """Checks the items of all types.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._bag = expressions.bag
        self._items = Items(expressions)
        self._of: dict[TypeSymbol, dict[str, Item]] = {}

    def check(self) -> plan.Coverage:
        """Return the sampled items, by the type that declares them."""
        symbols = self._expressions.program.structured()
        for symbol in symbols:
            for type_ in reversed(list(lineage(symbol))):
                if type_ not in self._of:
                    self._declare(type_)
        found = {symbol.name_in_plan: tuple(self._active(symbol)) for symbol in symbols}
        return {key: items for key, items in found.items() if items}

    def _active(self, symbol: TypeSymbol) -> Iterator[plan.AnyCoverageItem]:
        """Yield the type's own items that are valid and enabled."""
        known = {**self._inherited(symbol), **self._of[symbol]}
        for item in self._of[symbol].values():
            if item.plan is None or item.is_disabled:
                continue
            leaves = item.plan.items if isinstance(item.plan, plan.CrossItem) else ()
            if not any(known[leaf].is_disabled for leaf in leaves):
                yield item.plan

    def _inherited(self, symbol: TypeSymbol) -> dict[str, Item]:
        found: dict[str, Item] = {}
        for type_ in reversed(list(lineage(symbol))[1:]):
            found.update(self._of[type_])
        return found

    # ------------------------------------------------------------ the declarations of one type

    def _declare(self, symbol: TypeSymbol) -> None:
        own = self._of[symbol] = {}
        written = list(_declarations(symbol))
        inherited = self._inherited(symbol)
        read = [(node, self._read(symbol, node, home, field)) for node, home, field in written]
        named = [_identifier(arguments.get("name")) for _, (_, arguments, _) in read]
        places = {name.text: name.span for name in named if name is not None}
        for node, (scope, arguments, field) in read:
            if "override" in arguments:
                self._override(symbol, node, arguments, inherited, places)
                continue
            draft = self._draft(symbol, node, arguments, scope, field)
            if draft is None:
                continue
            first = own.get(draft.name.text) or inherited.get(draft.name.text)
            if first is None:
                own[draft.name.text] = self._items.elaborate(draft, ChainMap(own, inherited), places)
            else:
                self._report_second(draft, first)

    def _report_second(self, draft: Draft, first: Item) -> None:
        owner, name = draft.owner.qualified_name, draft.name
        place, is_inherited = first.draft.name.span, first.draft.owner is not draft.owner
        self._bag.add(messages.duplicate_item, name.span, draft.kind, name.text, owner, place, is_inherited)

    def _read(
        self, symbol: TypeSymbol, node: ast.CoverageDeclaration, home: Home, field: FieldSymbol | None
    ) -> tuple[Scope, dict[str, Argument], FieldSymbol | None]:
        """Return scope and arguments of a declaration; in the `with:` block of a field, `it` is the field."""
        scope = running_scope(symbol, home)
        if field is not None:
            scope = replace(scope, it=field.type, is_it_bound=True)
        return scope, collect(node.kind, node.arguments, scope, self._bag), field

    def _draft(
        self,
        symbol: TypeSymbol,
        node: ast.CoverageDeclaration,
        arguments: Mapping[str, Argument],
        scope: Scope,
        field: FieldSymbol | None,
    ) -> Draft | None:
        """Create a new item; report a missing name and return None."""
        argument = arguments.get("name")
        if argument is None:
            self._bag.add(messages.missing_name, node.span.head(node.kind), node.kind)
            return None
        name = _identifier(argument)
        if name is None:
            self._bag.add(messages.invalid_name, argument.value.span, node.kind)
            return None
        return Draft(name, node.kind, symbol, field, scope, arguments, node.span)

    # ------------------------------------------------------------ overrides (7.5.6)

    def _override(
        self,
        symbol: TypeSymbol,
        node: ast.CoverageDeclaration,
        arguments: Mapping[str, Argument],
        inherited: dict[str, Item],
        places: Mapping[str, Span],
    ) -> None:
        own = self._of[symbol]
        name = _identifier(arguments["override"])
        if name is None:
            place = arguments["override"].value.span
            self._bag.add(messages.invalid_argument_value, place, "override", "the name of an item")
            return
        item = own.get(name.text)
        if item is None:
            self._report_missing(symbol, name, inherited, places)
            return
        place = item.draft.name.span
        if item.draft.kind != node.kind:
            reason = f"`{name.text}` is declared as `{item.draft.kind}`"
            hint = f"write `{item.draft.kind}(override: {name.text}, ...)`"
            self._bag.add(messages.invalid_item_override, node.span.head(node.kind), reason, place, hint)
            return
        for fixed in _FIXED:
            if fixed in arguments:
                reason = f"an override cannot change the `{fixed}` of an item"
                self._bag.add(messages.invalid_item_override, arguments[fixed].place, reason, place)
        changed = {key: value for key, value in arguments.items() if key not in (*_FIXED, "override")}
        draft = replace(item.draft, arguments={**item.draft.arguments, **changed})
        own[name.text] = self._items.elaborate(draft, ChainMap(own, inherited), places)

    def _report_missing(
        self, symbol: TypeSymbol, name: ast.Name, inherited: Mapping[str, Item], places: Mapping[str, Span]
    ) -> None:
        item = inherited.get(name.text)
        if item is None and self._expressions.program.is_unread(name.text):
            return
        if item is None:
            owner, known = symbol.qualified_name, tuple(self._of[symbol])
            self._bag.add(messages.unknown_item, name.span, name.text, owner, known, places.get(name.text))
            return
        owner = item.draft.owner.qualified_name
        reason = f"`{name.text}` is an item of `{owner}` and can be overridden only there"
        hint = f"write it in `extend {owner}:`"
        self._bag.add(messages.invalid_item_override, name.span, reason, item.draft.name.span, hint)


def _declarations(
    symbol: TypeSymbol,
) -> Iterator[tuple[ast.CoverageDeclaration, Home, FieldSymbol | None]]:
    """Yield the items of a type and its extensions, in order, with the fields that contain them."""
    for part in symbol.parts:
        for member in part.members:
            match member:
                case ast.CoverageDeclaration():
                    yield member, part.home, None
                case ast.ParameterDeclaration(field_names, coverage=(_, *_) as nodes):
                    for field in declared(symbol, field_names):
                        yield from ((node, part.home, field) for node in nodes)
                case _:
                    pass


def _identifier(argument: Argument | None) -> ast.Name | None:
    """Return the name that is the value of an argument; None for other values."""
    if argument is None or not isinstance(argument.value, ast.NameExpression):
        return None
    return argument.value.name
