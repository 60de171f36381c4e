"""Second pass: resolve extensions, references of declarations, bases, and the types of fields."""

from __future__ import annotations

from typing import assert_never

from seoro.lang import ast, symbols
from seoro.lang.check.declare import Declared, describe_kind
from seoro.lang.check.enumerations import Enumerations
from seoro.lang.check.lookup import Lookup
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors, coverage, names, types
from seoro.lang.namespaces import Home, Space
from seoro.lang.program import Declaration, Program, actors_with
from seoro.lang.types import BOOL, PRIMITIVES, UNKNOWN, is_number

MAX_BASES = 100  # in a chain, which lookups of names and conditions follow


class Resolver:
    """Resolves the declarations of a program.

    Args:
        program: The program, with all declarations.
        bag: Bag for messages.
    """

    def __init__(self, program: Program, bag: Bag) -> None:
        self._program = program
        self._bag = bag
        self._lookup = Lookup(program, bag)

    def resolve(self, declared: Declared) -> None:
        """Resolve everything except members, in the order of dependencies."""
        program = self._program
        for extension, home in declared.extensions:
            self._extend(extension, home)
        Enumerations(program, self._lookup, self._bag).resolve()
        structured = program.structured()
        for symbol in structured:
            self._find_base(symbol)
            self._find_modified(symbol)
        self._check_lines(structured)
        for symbol in structured:
            self._check_actor(symbol)
        for parameter, home in declared.globals:
            type_ = self.type_of(parameter.type, home.space)
            for name in parameter.names:
                program.globals[home.namespace_of(name), name.text].type = type_
            for item in parameter.coverage:
                span, name = item.span.head(item.kind), parameter.names[0]
                self._bag.add(coverage.misplaced_item, span, item.kind, name.text)

    # ------------------------------------------------------------ extensions (7.3.9)

    def _extend(
        self,
        extension: ast.EnumTypeExtension | ast.StructuredTypeExtension | ast.PrimitiveTypeExtension,
        home: Home,
    ) -> None:
        match extension:
            case ast.EnumTypeExtension(name, members):
                enum = self._lookup.type(home.space, name)
                if isinstance(enum, symbols.EnumSymbol):
                    enum.declared += [(member, home) for member in members]
                else:
                    self._report_type(enum, name, "an enumeration")
            case ast.StructuredTypeExtension(behavior, body):
                symbol = self._extended(behavior, home.space)
                if symbol is not None:
                    symbol.parts.append(symbols.Part(body, home))
            case ast.PrimitiveTypeExtension():
                pass  # its methods are declared with those of the other types
            case _:
                assert_never(extension)

    def _extended(self, behavior: ast.BehaviorName, space: Space) -> symbols.TypeSymbol | None:
        """Find the extended type; report an unknown one and return None."""
        if behavior.actor is not None:
            return self._behavior(behavior, space)
        found = self._lookup.type(space, behavior.name) or self._lookup.behavior(space, None, behavior.name)
        if isinstance(found, symbols.TypeSymbol):
            return found
        modifier = self._lookup.modifier(space, None, behavior.name)
        self._report_type(found or modifier, behavior.name, "a type that can be extended")
        return None

    def _behavior(self, name: ast.BehaviorName, space: Space) -> symbols.TypeSymbol | None:
        """Find a scenario or an action; report an unknown one and return None."""
        actor: symbols.TypeSymbol | None = None
        if name.actor is not None:
            owner = self._lookup.type(space, name.actor)
            if not isinstance(owner, symbols.TypeSymbol) or owner.kind is not symbols.Kind.ACTOR:
                self._report_type(owner, name.actor, "an actor", symbols.Kind.ACTOR)
                return None
            actor = owner
        found = self._lookup.behavior(space, actor, name.name)
        if found is None:
            self._report_behavior(name, actor, space)
        return found

    def _find_modified(self, symbol: symbols.TypeSymbol) -> None:
        """Find the behavior that a modifier is `of`: one of its actor, unless another is named, or of none."""
        declaration = symbol.declaration
        if not isinstance(declaration, ast.ModifierDeclaration) or declaration.of is None:
            return
        name = declaration.of
        if name.actor is None and symbol.actor is not None:
            symbol.of = self._lookup.behavior(symbol.home.space, symbol.actor, name.name)
        symbol.of = symbol.of or self._behavior(name, symbol.home.space)
        symbol.is_open = symbol.of is None

    # ------------------------------------------------------------ bases (7.3.8)

    def _find_base(self, symbol: symbols.TypeSymbol) -> None:
        inheritance = _inheritance(symbol)
        if inheritance is None:
            return
        base = self._lookup_base(symbol, inheritance.base)
        if base is None:
            symbol.is_open = True
        elif base.kind is not symbol.kind:
            needed = describe_kind(symbol)
            self._bag.add(
                names.wrong_kind, inheritance.base.span, base.qualified_name, describe_kind(base), needed
            )
        else:
            symbol.base = base

    def _lookup_base(self, symbol: symbols.TypeSymbol, name: ast.BehaviorName) -> symbols.TypeSymbol | None:
        if symbol.kind in {symbols.Kind.SCENARIO, symbols.Kind.ACTION} or name.actor is not None:
            return self._behavior(name, symbol.home.space)
        found = self._lookup.type(symbol.home.space, name.name)
        if isinstance(found, symbols.TypeSymbol):
            return found
        self._report_type(found, name.name, describe_kind(symbol), symbol.kind)
        return None

    def _report_behavior(self, name: ast.BehaviorName, actor: symbols.TypeSymbol | None, space: Space) -> None:
        if self._program.is_unread(name.name.text):
            return
        if self._lookup.modifier(space, actor, name.name) is not None:
            needed = "a scenario or an action"
            self._bag.add(names.wrong_kind, name.span, name.span.text, "a modifier", needed)
            return
        owners = set(symbols.lineage(actor)) if actor is not None else {None}
        known = tuple(symbol.name for (_, owner, _), symbol in self._program.behaviors.items() if owner in owners)
        owner_name, text = actor.name if actor is not None else None, name.name.text
        others = actors_with(self._program.behaviors, text)
        hint = f"it belongs to actor `{others[0]}`; write `{others[0]}.{text}`" if others and actor is None else ""
        self._bag.add(behaviors.unknown_behavior, name.span, text, owner_name, known, hint)

    def _check_lines(self, structured: list[symbols.TypeSymbol]) -> None:
        """Cut cyclic bases, and chains of bases that are too long."""
        depths: dict[symbols.TypeSymbol, int] = {}  # number of bases
        for symbol in structured:
            path: dict[symbols.TypeSymbol, None] = {}
            current: symbols.TypeSymbol | None = symbol
            while current is not None and current not in depths:
                if current in path:
                    order = list(path)
                    self._cut_circle(order[order.index(current) :])
                    break
                path[current] = None
                current = current.base
            for type_ in reversed(path):
                depths[type_] = 0 if type_.base is None else depths[type_.base] + 1
                if depths[type_] > MAX_BASES:
                    self._bag.add(names.too_many_bases, type_.span, MAX_BASES)
                    type_.base, type_.is_open, depths[type_] = None, True, 0

    def _cut_circle(self, circle: list[symbols.TypeSymbol]) -> None:
        """Report types that inherit each other, and remove the base of the last one."""
        names_ = tuple(type_.qualified_name for type_ in (*circle, circle[0]))
        self._bag.add(names.cyclic_reference, circle[0].span, "bases", names_)
        circle[-1].base, circle[-1].is_open = None, True

    def _check_actor(self, symbol: symbols.TypeSymbol) -> None:
        """Check that the base of a scenario or an action belongs to the same actor or a base of it."""
        base = symbol.base
        if base is None or symbol.kind in {symbols.Kind.STRUCT, symbols.Kind.ACTOR}:
            return
        owners = set(symbols.lineage(symbol.actor)) if symbol.actor is not None else {None}
        if base.actor not in owners:
            inheritance = _inheritance(symbol)
            assert inheritance is not None
            span = inheritance.base.span
            self._bag.add(names.invalid_base, span, symbol.qualified_name, base.qualified_name)

    # ------------------------------------------------------------ conditions (7.3.8.2)

    def resolve_conditions(self) -> None:
        """Find the deciding fields of conditional subtypes, after all members are declared."""
        conditional = [symbol for symbol in self._program.structured() if _condition(symbol) is not None]
        for symbol in sorted(conditional, key=lambda found: len(list(symbols.lineage(found)))):
            self._resolve_condition(symbol)
        for symbol in self._program.structured():
            base = symbol.base
            if base is not None and _condition(base) is not None and _condition(symbol) is None:
                inheritance = _inheritance(symbol)
                assert inheritance is not None
                span = inheritance.base.span
                self._bag.add(names.unconditional_base, span, symbol.name, base.name)

    def _resolve_condition(self, symbol: symbols.TypeSymbol) -> None:
        condition = _condition(symbol)
        if symbol.base is None or condition is None:
            return
        name, value = condition
        fields = symbol.base.inventory.fields
        field = self._lookup.member(symbol.home.space, fields, name)
        if field is None:
            known = tuple(found.text for found in fields.values())
            self._bag.add(names.unknown_field, name.span, f"`{symbol.base.name}`", name.text, known)
        elif field.is_variable:
            self._bag.add(names.variable_determinant, name.span, name.text, field.span)
        elif self._decides(field.type, value, symbol.home.space):
            symbol.condition = symbols.Condition(field, value)
            self._program.conditionals.append(symbol)

    def _decides(self, type_: symbols.Type, value: ast.EnumValueReference | ast.BoolLiteral, space: Space) -> bool:
        """Return whether a value belongs to a boolean or enumerated field; report other values."""
        match type_, value:
            case symbols.Enumeration(enum), ast.EnumValueReference(prefix, member):
                if prefix is not None and self._lookup.type(space, prefix) is not enum:
                    self._bag.add(names.wrong_kind, prefix.span, prefix.text, "another type", f"`{enum.name}`")
                elif member.text in enum.members:
                    return True
                else:
                    known = tuple(enum.members)
                    self._bag.add(names.unknown_member, member.span, enum.name, member.text, known)
            case _ if type_ == BOOL and isinstance(value, ast.BoolLiteral):
                return True
            case _ if type_ != UNKNOWN:
                self._bag.add(types.invalid_condition, value.span)
            case _:
                pass
        return False

    # ------------------------------------------------------------ type declarators

    def type_of(self, declarator: ast.TypeDeclarator, space: Space) -> symbols.Type:
        """Return the type of a declarator; report an unknown one and return Unknown."""
        match declarator:
            case ast.PrimitiveTypeName(text):
                return PRIMITIVES[text]
            case ast.ListTypeDeclarator(element, span):
                inner = self.type_of(element, space)
                if isinstance(inner, symbols.ListOf):
                    self._bag.add(types.list_of_list, span)
                    return UNKNOWN
                return symbols.ListOf(inner)
            case ast.RangeTypeDeclarator(element, span):
                inner = self.type_of(element, space)
                if inner != UNKNOWN and not is_number(inner):
                    self._bag.add(types.not_numeric_range, span, f"`{element.span.text}`")
                    return UNKNOWN
                return symbols.RangeOf(inner)
            case ast.NamedType(name):
                return self._named(name, space)
            case _:
                assert_never(declarator)

    def _named(self, name: ast.BehaviorName, space: Space) -> symbols.Type:
        if name.actor is not None:
            behavior = self._behavior(name, space)
            return symbols.Structured(behavior) if behavior is not None else UNKNOWN
        match self._lookup.type(space, name.name):
            case symbols.QuantitySymbol() as quantity:
                return symbols.Quantity(quantity.dimension)
            case symbols.EnumSymbol() as enum:
                return symbols.Enumeration(enum)
            case symbols.TypeSymbol() as symbol:
                return symbols.Structured(symbol)
            case None:
                behavior = self._lookup.behavior(space, None, name.name)
                if behavior is not None:
                    return symbols.Structured(behavior)
                self._report_type(self._lookup.modifier(space, None, name.name), name.name, "a type")
                return UNKNOWN

    def _report_type(
        self,
        found: Declaration | None,
        name: ast.Name,
        needed: str,
        kind: symbols.Kind | None = None,
    ) -> None:
        if found is not None:
            self._bag.add(names.wrong_kind, name.span, name.text, describe_kind(found), needed)
            return
        if self._program.is_unread(name.text):
            return
        candidates = tuple(
            f"{symbol.namespace}::{symbol.name}" if symbol.name == name.text else symbol.name
            for symbol in self._program.types.values()
            if kind is None or (isinstance(symbol, symbols.TypeSymbol) and symbol.kind is kind)
        )
        candidates += tuple(PRIMITIVES) if kind is None else ()
        self._bag.add(names.unknown_type, name.span, name.text, candidates, kind.value if kind else "type")


def _inheritance(symbol: symbols.TypeSymbol) -> ast.Inheritance | None:
    declaration = symbol.declaration
    return None if isinstance(declaration, ast.ModifierDeclaration) else declaration.inheritance


def _condition(symbol: symbols.TypeSymbol) -> tuple[ast.Name, ast.EnumValueReference | ast.BoolLiteral] | None:
    """Return the condition of a type from the tree."""
    inheritance = _inheritance(symbol)
    return inheritance.condition if inheritance is not None else None
