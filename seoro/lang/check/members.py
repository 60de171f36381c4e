"""Third pass: declare the members of types, bases first; own members, then extensions in source order.

A member has a name in a namespace (7.7.4.2). Duplicate members of a type are an error. Exceptions are methods that
override with `only` (7.3.7.2), and events, which subtypes may declare again (7.3.10.2).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from seoro.lang import ast, symbols
from seoro.lang.check.declare import Declared, describe_kind
from seoro.lang.check.lookup import Lookup
from seoro.lang.check.resolve import Resolver
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors, events, modifiers, names
from seoro.lang.diagnostics import methods as method_messages
from seoro.lang.members import MemberTable
from seoro.lang.namespaces import Home
from seoro.lang.program import Program
from seoro.lang.types import PRIMITIVES

_Member = symbols.FieldSymbol | symbols.EventSymbol | symbols.MethodSymbol


class Members:
    """Declares the members of all types.

    Args:
        program: The program, with all types and their bases.
        resolver: Resolver of the types of members.
        bag: Bag for messages.
    """

    def __init__(self, program: Program, resolver: Resolver, bag: Bag) -> None:
        self._program = program
        self._resolver = resolver
        self._lookup = Lookup(program, bag)
        self._bag = bag
        self._done: set[symbols.TypeSymbol] = set()

    def declare(self, declared: Declared) -> None:
        """Declare the members of all types."""
        for symbol in self._program.structured():
            self._declare(symbol)
        for extension, home in declared.extensions:
            if isinstance(extension, ast.PrimitiveTypeExtension):
                receiver = PRIMITIVES[extension.type.text]
                methods = self._program.primitives.setdefault(extension.type.text, MemberTable())
                for member in extension.members:
                    if isinstance(member, ast.MethodDeclaration):
                        method = self._method(member, None, receiver, home, methods)
                        if self._is_taken(method, methods, member.only):
                            methods.add(method)

    def _declare(self, symbol: symbols.TypeSymbol) -> None:
        """Declare the members of a type, after those of its bases; chains of bases may be long."""
        pending = [symbol]
        while pending:
            current = pending[-1]
            if current.base is not None and current.base not in self._done:
                pending.append(current.base)
                continue
            pending.pop()
            if current not in self._done:
                self._done.add(current)
                if current.base is not None:
                    current.inventory = current.base.inventory.inherited()
                for part in current.parts:
                    self._declare_part(current, part)
                self._find_do(current)

    def _declare_part(self, symbol: symbols.TypeSymbol, part: symbols.Part) -> None:
        home = part.home
        for member in part.members:
            self._check_place(symbol, member)
            match member:
                case ast.ParameterDeclaration(field_names, declared, default, constraints):
                    symbol.is_constrained |= bool(constraints)
                    self._add_fields(symbol, field_names, declared, default, home)
                case ast.VariableDeclaration(field_names, declared, value):
                    first = value.default if isinstance(value, ast.SampleExpression) else value
                    self._add_fields(symbol, field_names, declared, first, home, is_variable=True)
                case ast.KeepConstraint():
                    symbol.is_constrained = True
                case ast.EventDeclaration():
                    self._add_event(symbol, member, home)
                case ast.MethodDeclaration():
                    method = self._method(
                        member, symbol, symbols.Structured(symbol), home, symbol.inventory.methods
                    )
                    self._add_method(symbol, method, member.only)
                case _:
                    pass

    def _check_place(self, symbol: symbols.TypeSymbol, member: ast.TypeMember) -> None:
        """Report behavior in extensions of structs and actors."""
        if symbol.kind in {symbols.Kind.STRUCT, symbols.Kind.ACTOR} and isinstance(
            member, ast.OnDirective | ast.DoDirective
        ):
            word = "on" if isinstance(member, ast.OnDirective) else "do"
            kind = describe_kind(symbol)
            self._bag.add(modifiers.misplaced_member, member.span.head(word), word, symbol.name, kind)

    def _find_do(self, symbol: symbols.TypeSymbol) -> None:
        """Find the only `do`, including inherited ones and extensions (7.3.5.1.3); report others."""
        inherited = symbol.base.do if symbol.base is not None else None
        own = [
            symbols.DoFound(symbol, found, part.home)
            for part in symbol.parts
            for found in part.members
            if isinstance(found, ast.DoDirective)
        ]
        symbol.do = own[0] if own else inherited
        first = inherited or symbol.do
        for second in own if inherited is not None else own[1:]:
            assert first is not None
            place, other = second.directive.span.head("do"), first.directive.span.head("do")
            self._bag.add(behaviors.duplicate_do, place, other, inherited is not None)

    # ------------------------------------------------------------ fields and events

    def _add_fields(
        self,
        symbol: symbols.TypeSymbol,
        field_names: tuple[ast.Name, ...],
        declared: ast.TypeDeclarator,
        default: ast.Expression | None,
        home: Home,
        is_variable: bool = False,
    ) -> None:
        type_ = self._resolver.type_of(declared, home.space)
        for name in field_names:
            space = home.namespace_of(name)
            unique = self._unique(name.text, space, symbol.inventory.fields)
            field = symbols.FieldSymbol(
                unique, type_, default, symbol, name.span, home, name.text, space, is_variable
            )
            if self._is_new(symbol, field):
                symbol.fields[unique] = field
                symbol.inventory.fields.add(field)

    def _add_event(self, symbol: symbols.TypeSymbol, node: ast.EventDeclaration, home: Home) -> None:
        name, space = node.name, home.namespace_of(node.name)
        if symbols.has_phases(symbol) and name.text in symbols.PHASES:
            self._bag.add(events.predefined_event, name.span, name.text)
            return
        if node.parameters and node.specification is not None:
            self._bag.add(events.specification_with_parameters, node.specification.span, name.text)
        unique = self._unique(name.text, space, symbol.inventory.events)
        parameters = self._parameters(node.parameters, symbol, home)
        event = symbols.EventSymbol(
            unique, symbol, name.span, home, node.specification, name.text, space, parameters
        )
        if self._is_new(symbol, event) and self._may_override(event, symbol.inventory.events.get(unique)):
            symbol.events[unique] = event
            symbol.inventory.events.add(event)

    def _may_override(self, event: symbols.EventSymbol, overridden: symbols.EventSymbol | None) -> bool:
        """Return whether an event may override that of a base; report a mismatch."""
        if overridden is None:
            return True
        difference = _difference(event, overridden)
        if difference:
            self._bag.add(events.event_mismatch, event.span, event.text, difference, overridden.span)
            return False
        _inherit_defaults(event, overridden)
        return True

    def _parameters(
        self, parameters: tuple[ast.ArgumentSpecification, ...], owner: symbols.TypeSymbol | None, home: Home
    ) -> MemberTable[symbols.FieldSymbol]:
        """Declare the parameters of an event or a method."""
        found: MemberTable[symbols.FieldSymbol] = MemberTable()
        for parameter in parameters:
            name, space = parameter.name, home.namespace_of(parameter.name)
            type_ = self._resolver.type_of(parameter.type, home.space)
            if name.text in found:
                self._bag.add(names.duplicate, name.span, "parameter", name.text, found[name.text].span)
                continue
            found.add(
                symbols.FieldSymbol(name.text, type_, parameter.default, owner, name.span, home, name.text, space)
            )
        return found

    def _is_new(self, symbol: symbols.TypeSymbol, member: _Member) -> bool:
        """Return whether a member is new in a type and its bases; report duplicates."""
        for other in self._namesakes(symbol, member):
            if other is not None:
                if not self._program.is_unread(member.text):
                    self._bag.add(names.duplicate, member.span, "member", member.text, other.span)
                return False
        return True

    @staticmethod
    def _namesakes(symbol: symbols.TypeSymbol, member: _Member) -> Iterator[_Member | None]:
        """Yield members with the same identifier and namespace, except overridden events."""
        yield symbol.inventory.fields.with_text(member.text).get(member.namespace)
        yield symbol.inventory.methods.with_text(member.text).get(member.namespace)
        event = symbol.inventory.events.with_text(member.text).get(member.namespace)
        if event is not None and not (isinstance(member, symbols.EventSymbol) and event.owner is not symbol):
            yield event

    @staticmethod
    def _unique(
        text: str, namespace: str, others: MemberTable[symbols.FieldSymbol] | MemberTable[symbols.EventSymbol]
    ) -> str:
        """Return a unique name for a field or an event; other namespaces may have the same identifier."""
        other = others.get(text)
        return text if other is None or other.namespace == namespace else f"{namespace}::{text}"

    # ------------------------------------------------------------ methods (7.3.7)

    def _method(
        self,
        node: ast.MethodDeclaration,
        owner: symbols.TypeSymbol | None,
        receiver: symbols.Type,
        home: Home,
        others: MemberTable[symbols.MethodSymbol],
    ) -> symbols.MethodSymbol:
        """Declare a method; with `only` it may override one of a used namespace."""
        name, namespace = node.name, home.namespace_of(node.name)
        if node.only and (overridden := self._lookup.member(home.space, others, name)) is not None:
            namespace = overridden.namespace
        parameters = self._parameters(node.parameters, owner, home)
        result = self._resolver.type_of(node.result, home.space) if node.result is not None else None
        unique = f"{namespace}::{name.text}"
        if isinstance(receiver, symbols.Primitive):
            unique = f"{receiver.name} {unique}"  # by the declared type: values of int and uint are alike
        return symbols.MethodSymbol(
            unique, name.text, namespace, owner, receiver, parameters, result, node.implementation, home, name.span
        )

    def _add_method(self, symbol: symbols.TypeSymbol, method: symbols.MethodSymbol, only: bool) -> None:
        methods = symbol.inventory.methods
        is_new = method.name not in methods and self._is_new(symbol, method)
        if (is_new or method.name in methods) and self._is_taken(method, methods, only):
            symbol.methods[method.name] = method
            methods.add(method)

    def _is_taken(
        self, method: symbols.MethodSymbol, methods: MemberTable[symbols.MethodSymbol], only: bool
    ) -> bool:
        """Return whether another method prevents adding this one, which is reported."""
        overridden = methods.get(method.name)
        if overridden is None:
            return True
        if not only:
            self._bag.add(method_messages.missing_only, method.span, method.text, overridden.span)
            return False
        difference = _difference(method, overridden) or (
            "" if method.result == overridden.result else "its result"
        )
        if difference:
            self._bag.add(method_messages.method_mismatch, method.span, method.text, difference, overridden.span)
            return False
        _inherit_defaults(method, overridden)
        return True


_WithParameters = TypeVar("_WithParameters", symbols.EventSymbol, symbols.MethodSymbol)


def _difference(member: _WithParameters, overridden: _WithParameters) -> str:
    """Describe how parameters differ from those of the overridden event or method (7.3.7.2)."""
    if [*member.parameters] != [*overridden.parameters]:
        return "its parameters"
    for name, parameter in member.parameters.items():
        if parameter.type != overridden.parameters[name].type:
            return f"the type of `{name}`"
    return ""


def _inherit_defaults(member: _WithParameters, overridden: _WithParameters) -> None:
    """Give parameters without a default that of the overridden member."""
    for name, parameter in member.parameters.items():
        if parameter.default is None:
            inherited = overridden.parameters[name]
            parameter.default, parameter.home = inherited.default, inherited.home
