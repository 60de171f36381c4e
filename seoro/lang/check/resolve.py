"""Second pass: what declarations refer to, the numbers of enumerations, bases, and the types of members."""

from __future__ import annotations

from typing import assert_never

from seoro.lang import ast
from seoro.lang.check.declare import describe_kind
from seoro.lang.check.unsupported import refuse_member
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as behavior_messages
from seoro.lang.diagnostics import names
from seoro.lang.diagnostics import types as messages
from seoro.lang.diagnostics.unsupported import Construct, NotSupported
from seoro.lang.source import Span
from seoro.lang.symbols import (
    EnumSymbol,
    EventSymbol,
    FieldSymbol,
    Kind,
    Program,
    QuantitySymbol,
    TypeSymbol,
    do_directive,
    lineage,
)
from seoro.lang.types import (
    PRIMITIVES,
    UNKNOWN,
    Enumeration,
    ListOf,
    Quantity,
    RangeOf,
    Structured,
    Type,
    is_number,
)


class Resolver:
    """Resolves the declarations of a program.

    Args:
        program: The program, with all declarations.
        bag: Where messages go.
    """

    def __init__(self, program: Program, bag: Bag) -> None:
        self._program = program
        self._bag = bag

    def resolve(self) -> None:
        """Resolve everything, in the order in which one needs the other."""
        program = self._program
        for enum in [symbol for symbol in program.types.values() if isinstance(symbol, EnumSymbol)]:
            self._number_members(enum)
        structured = self.structured()
        for symbol in structured:
            self._find_base(symbol)
        for symbol in structured:
            self._break_cycle(symbol)
        for symbol in structured:
            self._declare_members(symbol)
        for symbol in structured:
            self._compare_with_bases(symbol)

    def structured(self) -> list[TypeSymbol]:
        """All structs, actors, scenarios, actions and modifiers."""
        program = self._program
        types = [symbol for symbol in program.types.values() if isinstance(symbol, TypeSymbol)]
        return [*types, *program.behaviors.values(), *program.modifiers.values()]

    # ------------------------------------------------------------ enumerations (7.3.3)

    def _number_members(self, enum: EnumSymbol) -> None:
        first: dict[str, Span] = {}
        for member in enum.declaration.members:
            name = member.name
            if name.text in first:
                self._bag.add(names.Duplicate(name.span, "member", name.text, first[name.text]))
            else:
                first[name.text] = name.span
                enum.members[name.text] = self._number(enum, name.text, ()) or 0

    def _number(self, enum: EnumSymbol, wanted: str, path: tuple[tuple[EnumSymbol, str], ...]) -> int | None:
        """The number of a member; None if it cannot be told, which has been reported."""
        following = 0
        for member in enum.declaration.members:
            match member.value:
                case None:
                    number: int | None = following
                    following += 1
                case int() as number:
                    following = number + 1
                case ast.EnumValueReference() as reference:
                    if member.name.text != wanted:
                        continue
                    return self._referenced(enum, wanted, reference, path)
                case _:
                    assert_never(member.value)
            if member.name.text == wanted:
                return number
        return None

    def _referenced(
        self,
        enum: EnumSymbol,
        member: str,
        reference: ast.EnumValueReference,
        path: tuple[tuple[EnumSymbol, str], ...],
    ) -> int | None:
        here = (enum, member)
        if here in path:
            if path[0] == here:
                cycle = (*(name for _, name in path), member)
                self._bag.add(names.CyclicReference(reference.span, "values of members", cycle))
            return None
        target = self.find_member(enum.home.namespace, reference, enum)
        return None if target is None else self._number(target, reference.member.text, (*path, here))

    def find_member(
        self, namespace: str, reference: ast.EnumValueReference, default: EnumSymbol | None
    ) -> EnumSymbol | None:
        """The enumeration that `[enum!]member` refers to; None if there is none, which is reported."""
        target = default
        if reference.enum is not None:
            found = self._program.find_type(namespace, reference.enum)
            if not isinstance(found, EnumSymbol):
                self._report_type(found, reference.enum, "an enumeration")
                return None
            target = found
        assert target is not None
        known = tuple(member.name.text for member in target.declaration.members)
        if reference.member.text not in known:
            self._bag.add(names.UnknownMember(reference.span, target.name, reference.member.text, known))
            return None
        return target

    # ------------------------------------------------------------ bases (7.3.8)

    def _find_base(self, symbol: TypeSymbol) -> None:
        declaration = symbol.declaration
        if isinstance(declaration, ast.ModifierDeclaration) or declaration.inheritance is None:
            return
        inheritance = declaration.inheritance
        if inheritance.condition is not None:
            span = inheritance.condition[0].span
            self._bag.add(NotSupported(span, Construct.CONDITIONAL_INHERITANCE))
            symbol.is_open = True
        base = self._lookup_base(symbol, inheritance.base)
        if base is None:
            symbol.is_open = True
        elif base.kind is not symbol.kind:
            needed = describe_kind(symbol)
            self._bag.add(names.WrongKind(inheritance.base.span, base.qualified_name, describe_kind(base), needed))
        else:
            symbol.base = base

    def _lookup_base(self, symbol: TypeSymbol, name: ast.BehaviorName) -> TypeSymbol | None:
        program, namespace = self._program, symbol.home.namespace
        is_behavior = symbol.kind in {Kind.SCENARIO, Kind.ACTION}
        if not is_behavior and name.actor is None:
            found = program.find_type(namespace, name.name)
            if isinstance(found, TypeSymbol):
                return found
            self._report_type(found, name.name, describe_kind(symbol), symbol.kind)
            return None
        actor: TypeSymbol | None = None
        if name.actor is not None:
            owner = program.find_type(namespace, name.actor)
            if not isinstance(owner, TypeSymbol) or owner.kind is not Kind.ACTOR:
                self._report_type(owner, name.actor, "an actor", Kind.ACTOR)
                return None
            actor = owner
        base = program.find_behavior(namespace, actor, name.name)
        if base is None:
            self._report_behavior(name, actor)
        return base

    def _report_behavior(self, name: ast.BehaviorName, actor: TypeSymbol | None) -> None:
        if self._program.is_lenient:
            return
        owners = set(lineage(actor)) if actor is not None else {None}
        known = tuple(symbol.name for (_, owner, _), symbol in self._program.behaviors.items() if owner in owners)
        owner_name = actor.name if actor is not None else None
        self._bag.add(behavior_messages.UnknownBehavior(name.span, name.name.text, owner_name, known))

    def _break_cycle(self, symbol: TypeSymbol) -> None:
        """Cut a base that leads back; a scenario's base belongs to the same actor or a more general one."""
        path = [symbol]
        while path[-1].base is not None:
            base = path[-1].base
            if base is symbol:
                names_ = tuple(type_.qualified_name for type_ in (*path, symbol))
                self._bag.add(names.CyclicReference(symbol.span, "bases", names_))
                symbol.base, symbol.is_open = None, True
                return
            if base in path:
                return
            path.append(base)
        own = symbol.base
        if own is None or symbol.kind in {Kind.STRUCT, Kind.ACTOR}:
            return
        owners = set(lineage(symbol.actor)) if symbol.actor is not None else {None}
        if own.actor not in owners:
            declaration = symbol.declaration
            assert not isinstance(declaration, ast.ModifierDeclaration) and declaration.inheritance is not None
            span = declaration.inheritance.base.span
            self._bag.add(names.WrongBase(span, symbol.qualified_name, own.qualified_name))

    # ------------------------------------------------------------ members

    def _declare_members(self, symbol: TypeSymbol) -> None:
        is_library = symbol.home.library is not None
        first_do: Span | None = None
        for member in symbol.declaration.members:
            if refuse_member(member, is_library, self._bag) and not isinstance(
                member,
                ast.ParameterDeclaration | ast.VariableDeclaration | ast.EventDeclaration | ast.MethodDeclaration,
            ):
                symbol.is_constrained |= isinstance(member, ast.KeepConstraint)
                continue
            match member:
                case ast.ParameterDeclaration(field_names, declared, default, constraints):
                    symbol.is_constrained |= bool(constraints)
                    type_ = self.type_of(declared, symbol.home.namespace)
                    for name in field_names:
                        self._add_field(symbol, FieldSymbol(name.text, type_, default, symbol, name.span))
                case ast.VariableDeclaration(field_names, declared):
                    type_ = self.type_of(declared, symbol.home.namespace)
                    for name in field_names:
                        self._add_field(symbol, FieldSymbol(name.text, type_, None, symbol, name.span))
                    symbol.is_open = True
                case ast.EventDeclaration(name, parameters):
                    self._add_event(symbol, name, parameters)
                case ast.MethodDeclaration(name, parameters, result):
                    self._add_method(symbol, name, parameters, result)
                case ast.DoDirective(span=span):
                    if first_do is not None:
                        self._bag.add(behavior_messages.SecondDo(_head(span), _head(first_do), inherited=False))
                    first_do = first_do or span
                case _:
                    pass

    def _add_field(self, symbol: TypeSymbol, field: FieldSymbol) -> None:
        if self._is_new(symbol, field.name, field.span):
            symbol.fields[field.name] = field

    def _add_event(
        self, symbol: TypeSymbol, name: ast.Name, parameters: tuple[ast.ArgumentSpecification, ...]
    ) -> None:
        event = EventSymbol(name.text, symbol, name.span)
        for parameter in parameters:
            type_ = self.type_of(parameter.type, symbol.home.namespace)
            self._add_parameter(event.parameters, parameter, type_, symbol)
        if self._is_new(symbol, name.text, name.span):
            symbol.events[name.text] = event

    def _add_method(
        self,
        symbol: TypeSymbol,
        name: ast.Name,
        parameters: tuple[ast.ArgumentSpecification, ...],
        result: ast.TypeDeclarator | None,
    ) -> None:
        declared: dict[str, FieldSymbol] = {}
        for parameter in parameters:
            type_ = self.type_of(parameter.type, symbol.home.namespace)
            self._add_parameter(declared, parameter, type_, symbol)
        if result is not None:
            self.type_of(result, symbol.home.namespace)
        if self._is_new(symbol, name.text, name.span):
            symbol.methods[name.text] = name.span

    def _add_parameter(
        self, found: dict[str, FieldSymbol], parameter: ast.ArgumentSpecification, type_: Type, owner: TypeSymbol
    ) -> None:
        name = parameter.name
        if name.text in found:
            self._bag.add(names.Duplicate(name.span, "parameter", name.text, found[name.text].span))
            return
        found[name.text] = FieldSymbol(name.text, type_, parameter.default, owner, name.span)

    def _is_new(self, symbol: TypeSymbol, name: str, span: Span) -> bool:
        """Whether a type has no member of this name yet; a second one is reported."""
        first = _member_span(symbol, name)
        if first is not None and not self._program.is_lenient:
            self._bag.add(names.Duplicate(span, "member", name, first))
        return first is None

    def _compare_with_bases(self, symbol: TypeSymbol) -> None:
        """Fields are not declared again below a base, and there is one `do` (7.3.8.1)."""
        if symbol.base is None:
            return
        for name, field in symbol.fields.items():
            for base in lineage(symbol.base):
                if (first := _member_span(base, name)) is not None and not self._program.is_lenient:
                    self._bag.add(names.Duplicate(field.span, "member", name, first))
                    break
        own = [member.span for member in symbol.declaration.members if isinstance(member, ast.DoDirective)]
        inherited = do_directive(symbol.base)
        if own and inherited is not None:
            self._bag.add(behavior_messages.SecondDo(_head(own[0]), _head(inherited[1].span), inherited=True))

    # ------------------------------------------------------------ type declarators

    def type_of(self, declarator: ast.TypeDeclarator, namespace: str) -> Type:
        """The type that a declarator means; Unknown if there is none, which is reported."""
        match declarator:
            case ast.PrimitiveTypeName(text):
                return PRIMITIVES[text]
            case ast.ListTypeDeclarator(element, span):
                inner = self.type_of(element, namespace)
                if isinstance(inner, ListOf):
                    self._bag.add(messages.ListOfList(span))
                    return UNKNOWN
                return ListOf(inner)
            case ast.RangeTypeDeclarator(element, span):
                inner = self.type_of(element, namespace)
                if inner != UNKNOWN and not is_number(inner):
                    self._bag.add(messages.NotNumericRange(span, f"`{element.span.text}`"))
                    return UNKNOWN
                return RangeOf(inner)
            case ast.NamedType(name):
                return self._named(name, namespace)
            case _:
                assert_never(declarator)

    def _named(self, name: ast.BehaviorName, namespace: str) -> Type:
        if name.actor is not None:
            self._bag.add(NotSupported(name.span, Construct.BEHAVIOR_TYPE, name.span.text))
            return UNKNOWN
        match self._program.find_type(namespace, name.name):
            case QuantitySymbol() as quantity:
                return Quantity(quantity.dimension)
            case EnumSymbol() as enum:
                return Enumeration(enum)
            case TypeSymbol() as symbol:
                return Structured(symbol)
            case None:
                if self._program.find_behavior(namespace, None, name.name) is not None:
                    self._bag.add(NotSupported(name.span, Construct.BEHAVIOR_TYPE, name.name.text))
                else:
                    self._report_type(None, name.name, "a type")
                return UNKNOWN

    def _report_type(
        self,
        found: QuantitySymbol | EnumSymbol | TypeSymbol | None,
        name: ast.Name,
        needed: str,
        kind: Kind | None = None,
    ) -> None:
        if found is not None:
            self._bag.add(names.WrongKind(name.span, name.text, describe_kind(found), needed))
            return
        if self._program.is_lenient:
            return
        candidates = tuple(
            symbol.name
            for symbol in self._program.types.values()
            if kind is None or (isinstance(symbol, TypeSymbol) and symbol.kind is kind)
        )
        self._bag.add(names.UnknownType(name.span, name.text, candidates, kind.value if kind else "type"))


def _member_span(symbol: TypeSymbol, name: str) -> Span | None:
    """Where a type itself declares a member."""
    if name in symbol.fields:
        return symbol.fields[name].span
    if name in symbol.events:
        return symbol.events[name].span
    return symbol.methods.get(name)


def _head(span: Span) -> Span:
    return Span(span.file, span.start, span.start + 2)
