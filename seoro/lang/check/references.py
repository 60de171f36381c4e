"""Resolution of names, members of enumerations, numbers with units and `it` (7.4.1)."""

from __future__ import annotations

from dataclasses import replace

from seoro.lang import ast, plan
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.labels import AllLabels
from seoro.lang.check.lookup import candidates
from seoro.lang.check.methods import Methods
from seoro.lang.check.plan_types import enum_value
from seoro.lang.check.scopes import OVERLAP_KIND, Scope
from seoro.lang.diagnostics import methods as method_messages
from seoro.lang.diagnostics import names, types
from seoro.lang.habits import UNITS, compound_unit
from seoro.lang.program import EnumMember
from seoro.lang.source import Span
from seoro.lang.symbols import Enumeration, EnumSymbol, Kind, QuantitySymbol, Type, TypeSymbol, is_open
from seoro.lang.types import quantity
from seoro.lang.units import to_si


class References:
    """Resolves expressions without operators.

    Args:
        expressions: The expression checker.
        methods: The methods of all types.
        labels: The labels of all types.
    """

    def __init__(self, expressions: ExpressionChecker, methods: Methods, labels: AllLabels) -> None:
        self._methods = methods
        self._labels = labels
        self._program = expressions.program
        self._bag = expressions.bag
        self._lookup = expressions.lookup

    def physical(self, node: ast.PhysicalLiteral) -> Typed:
        """Resolve a number with a unit."""
        unit = self._program.units.get(node.unit.text)
        if unit is None:
            if not self._program.is_unread(node.unit.text):
                self._bag.add(names.unknown_unit, node.unit.span, node.unit.text, tuple(self._program.units))
            return nothing(node.span)
        if self._program.recorder is not None:
            self._program.recorder.name(node.unit.span, unit)
        if unit.dimension is None:
            return nothing(node.span)
        value = to_si(node.value, unit.factor, unit.offset)
        return Typed(plan.Literal(value, node.span), quantity(unit.dimension))

    def enum_value(self, node: ast.EnumValueReference, scope: Scope) -> Typed:
        """Resolve a member with its enumeration."""
        assert node.enum is not None
        enum = self._lookup.type(scope.space, node.enum)
        if isinstance(enum, EnumSymbol):
            return self._member(enum, node.member.text, node.span)
        if enum is not None:
            self._bag.add(names.wrong_kind, node.enum.span, node.enum.text, "not an enumeration", "an enumeration")
        elif not self._program.is_unread(node.enum.text):
            known = self._program.types_of(EnumSymbol)
            self._bag.add(names.unknown_type, node.enum.span, node.enum.text, known, "enumeration")
        return nothing(node.span)

    def _member(self, enum: EnumSymbol, member: str, span: Span) -> Typed:
        if member in enum.members:
            if self._program.recorder is not None:
                self._program.recorder.name(span, EnumMember(enum, member))
            return Typed(plan.Literal(enum_value(enum, member), span), Enumeration(enum))
        if not self._program.is_unread(member):
            self._bag.add(names.unknown_member, span, enum.name, member, tuple(enum.members))
        return nothing(span)

    def name(self, name: ast.Name, scope: Scope, expected: Type | None) -> Typed:
        """Resolve a name; members of the expected enumeration come first."""
        if name.namespace is None and name.text in scope.bindings:
            return Typed(plan.Binding(name.text, name.span), scope.bindings[name.text])
        if expected == OVERLAP_KIND and name.namespace is None and name.text in OVERLAP_KIND.symbol.members:
            return Typed(plan.Literal(enum_value(OVERLAP_KIND.symbol, name.text), name.span), OVERLAP_KIND)
        found = self._lookup.member(scope.space, scope.fields, name)
        enum = expected.symbol if isinstance(expected, Enumeration) else None
        is_other = found is None or found.type != expected
        if enum is not None and is_other and self._lookup.is_member(scope.space, enum, name):
            return self._member(enum, name.text, name.span)
        if found is not None:
            return Typed(plan.Field(found.name, name.span), found.type)
        parameter = self._lookup.global_parameter(scope.space, name)
        if parameter is not None:
            return Typed(plan.Global(parameter.name, name.span), parameter.type)
        enums = self._lookup.enumerations(scope.space, name)
        if len(enums) == 1:
            return self._member(enums[0], name.text, name.span)
        if enums:
            self._bag.add(names.ambiguous_member, name.span, name.text, tuple(enum.name for enum in enums))
            return nothing(name.span)
        return self._unknown_name(name, scope, expected)

    def is_open_member(self, node: ast.Expression, scope: Scope) -> bool:
        """Return whether a name can only be a member of an enumeration that the other operand determines."""
        match node:
            case ast.NameExpression(name):
                is_bound = name.namespace is None and name.text in scope.bindings
                is_field = self._lookup.member(scope.space, scope.fields, name) is not None
                return not is_bound and not is_field and bool(self._lookup.enumerations(scope.space, name))
            case ast.ListConstructor(items):
                return any(self.is_open_member(item, scope) for item in items)
            case _:
                return False

    def it(self, span: Span, scope: Scope) -> Typed:
        """Resolve `it`."""
        if scope.it is None:
            self._bag.add(method_messages.undefined_it, span)
            return nothing(span)
        if scope.is_it_bound:
            return Typed(plan.Binding("it", span), scope.it)
        if scope.it_value is not None:
            return Typed(replace(scope.it_value, span=span), scope.it)
        return Typed(plan.Self(span), scope.it)

    def _unknown_name(self, name: ast.Name, scope: Scope, expected: Type | None) -> Typed:
        program = self._program
        if program.is_unread(name.text) or (scope.owner is not None and is_open(scope.owner)):
            return nothing(name.span)
        if isinstance(expected, Enumeration):
            self._bag.add(
                names.unknown_member, name.span, expected.symbol.name, name.text, tuple(expected.symbol.members)
            )
            return nothing(name.span)
        symbol = self._lookup.type(scope.space, name)
        if symbol is not None:
            kind = "a unit's type" if isinstance(symbol, QuantitySymbol) else "a type"
            hint = f"`{name.text}(...)` constructs a value" if _is_struct(symbol) else ""
            if isinstance(symbol, EnumSymbol):
                member = next(iter(symbol.members), "<member>")
                hint = f"write a member of an enumeration as `{name.text}!{member}`"
            self._bag.add(types.not_a_value, name.span, name.text, kind, hint)
        elif self._methods.own(name, scope) is not None:
            self._bag.add(types.not_a_value, name.span, name.text, "a method", f"call it: `{name.text}()`")
        elif scope.owner is not None and name.text in (labels := self._labels.of(scope.owner)):
            is_early, is_invocation = not scope.is_running, labels.is_invocation(name.text)
            self._bag.add(types.label_as_value, name.span, name.text, is_invocation, is_early)
        else:
            start, unit = compound_unit(name.span.file.text, name.span.start, name.span.end)
            if unit in UNITS:
                span = Span(name.span.file, start, name.span.end)
                self._bag.add(names.unknown_unit, span, unit, tuple(program.units))
                return nothing(name.span)
            members = candidates((*scope.fields.values(), *program.globals.values()), name)
            known = (*members, *scope.bindings, *program.enumerations_by_member)
            self._bag.add(names.unknown_name, name.span, name.text, known, scope.invoked)
        return nothing(name.span)


def _is_struct(symbol: QuantitySymbol | EnumSymbol | TypeSymbol) -> bool:
    return isinstance(symbol, TypeSymbol) and symbol.kind is Kind.STRUCT
