"""Structures of types, and construction of structs from arguments.

A field without a default of its own or of its type (`defaults.py`) needs an argument or a constraint. The seed may
choose booleans and members of enumerations. Structs and actors are constructed, and lists are empty.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property

from seoro.lang import ast, plan, symbols
from seoro.lang.check.arguments import Binding
from seoro.lang.check.constraints import Constraints
from seoro.lang.check.convert import Typed
from seoro.lang.check.defaults import Defaults
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.plan_types import enum_value, plan_type
from seoro.lang.check.scopes import Scope, scope_of
from seoro.lang.diagnostics import behaviors, syntax, types
from seoro.lang.source import Span
from seoro.lang.types import BOOL, UNKNOWN

MAX_DEPTH = 50  # of nested values, which are built recursively
GLOBALS = "globals"  # name of the structure of global parameters


class Values:
    """Elaborates structures, and constructs values.

    Args:
        expressions: The expression checker.
        constraints: Checker of constraints.
        defaults: The default values of fields.
    """

    def __init__(self, expressions: ExpressionChecker, constraints: Constraints, defaults: Defaults) -> None:
        self._expressions = expressions
        self._constraints = constraints
        self._defaults = defaults
        self._structures: dict[symbols.TypeSymbol, plan.Structure] = {}
        self._open: list[symbols.TypeSymbol] = []
        self._asked: list[symbols.TypeSymbol] = []  # types whose fields are being searched
        self._depths: dict[symbols.TypeSymbol, int] = {}  # nesting of structures
        self._conditions: dict[symbols.TypeSymbol, tuple[tuple[str, bool | plan.EnumValue], ...]] = {}
        self._subtypes_of: dict[symbols.TypeSymbol, list[symbols.TypeSymbol]] = {}

    def from_arguments(self, symbol: symbols.TypeSymbol, node: ast.FunctionApplication, scope: Scope) -> Typed:
        """Construct `name(arguments)`; other fields get their defaults."""
        fields = symbol.inventory.fields
        binding = Binding(self._expressions, symbol.name, fields, scope, symbols.is_open(symbol))
        given = binding.bind(node.arguments)
        self.check_conditions(symbol, given, is_known_later=True)
        missing = self.lacking_of(symbol, given)
        if missing:
            self._expressions.bag.add(behaviors.missing_argument, node.span, symbol.name, missing[0])
        arguments = tuple((name, given[name]) for name in fields if name in given)
        type_ = symbol.plan_type
        assert isinstance(type_, plan.StructType)
        return Typed(plan.Construct(type_, arguments, node.span), symbols.Structured(symbol))

    # ------------------------------------------------------------ conditions (7.3.8.2)

    def conditions(self, symbol: symbols.TypeSymbol) -> tuple[tuple[str, bool | plan.EnumValue], ...]:
        """Return the deciding fields of a conditional subtype, with their values."""
        known = self._conditions.get(symbol)
        if known is None:
            conditions = [type_.condition for type_ in reversed(list(symbols.lineage(symbol)))]
            known = self._conditions[symbol] = tuple(
                (found.field.name, _condition_value(found)) for found in conditions if found is not None
            )
        return known

    def check_conditions(
        self, symbol: symbols.TypeSymbol, given: Mapping[str, plan.Expression], is_known_later: bool = False
    ) -> None:
        """Report values that contradict the conditions of a type.

        Args:
            symbol: The type.
            given: Values for its fields.
            is_known_later: Whether the run compares values that are not known statically.
        """
        for name, needed in self.conditions(symbol):
            value = given.get(name)
            if value is None or (is_known_later and not isinstance(value, plan.Literal)):
                continue
            if not isinstance(value, plan.Literal) or value.value != needed:
                shown = needed.member if isinstance(needed, plan.EnumValue) else str(needed).lower()
                self._expressions.bag.add(types.fixed_by_condition, value.span, symbol.name, name, shown)

    # ------------------------------------------------------------ missing values

    def lacking_of(self, symbol: symbols.TypeSymbol, given: Mapping[str, object]) -> tuple[str, ...]:
        """Return the paths of a type's fields without a value, as far as known statically."""
        if symbols.may_lack_values(symbol) or any(map(symbols.may_lack_values, self._subtypes(symbol))):
            return ()
        decided = {*given, *dict(self.conditions(symbol))}
        fields = [field for field in symbol.inventory.fields.values() if field.name not in decided]
        self._asked.append(symbol)
        found = tuple(path for field in fields for path in self.lacking(field))
        self._asked.pop()
        return found

    def lacking(self, field: symbols.FieldSymbol) -> tuple[str, ...]:
        """Return the paths within a field that lack a value."""
        if self._defaults.of(field) is not None or field.default is not None or field.is_variable:
            return ()
        match field.type:
            case symbols.Structured(symbol) if symbol in self._asked:
                return ()
            case symbols.Structured(symbol):
                return tuple(f"{field.name}.{path}" for path in self.lacking_of(symbol, {}))
            case symbols.ListOf() | symbols.Enumeration():
                return ()
            case type_ if type_ in (BOOL, UNKNOWN):
                return ()
            case _:
                return (field.name,)

    # ------------------------------------------------------------ structures

    def structure(self, symbol: symbols.TypeSymbol) -> plan.Structure:
        """Return the structure of a type."""
        if symbol in self._structures:
            return self._structures[symbol]
        self._open.append(symbol)
        for field in symbol.inventory.fields.values():
            self._enter(field)
        self._measure(symbol)
        members = tuple(
            member for type_ in reversed(list(symbols.lineage(symbol))) for member in self._members(type_)
        )
        latents = tuple(self._latent(subtype) for subtype in self._subtypes(symbol))
        made = self._made(symbol.plan_type, members, latents, symbol.span, _is_modified(symbol))
        self._open.pop()
        self._structures[symbol] = made
        self._expressions.program.structures.add(made)
        return made

    def globals(self) -> plan.Structure:
        """Return the structure of the global parameters (7.3.14)."""
        program = self._expressions.program
        members: list[plan.StructureMember] = []
        for declaration, home in program.global_declarations:
            for name in declaration.names:
                symbol = program.globals[home.namespace_of(name), name.text]
                if symbol.span is name.span:
                    self._enter(symbol)
                    members.append(self._field(symbol))
                    it = plan.Global(symbol.name, symbol.span)
                    members += self._with_block(declaration.constraints, scope_of(None, home), symbol, it)
        span = members[0].span if members else program.nowhere
        return self._made(plan.StructType(GLOBALS, (), ()), tuple(members), (), span)

    def _made(
        self,
        type_: plan.StructType | plan.ActorType,
        members: tuple[plan.StructureMember, ...],
        latents: tuple[plan.Latent, ...],
        span: Span,
        is_modified: bool = False,
    ) -> plan.Structure:
        fields = {member.name: member for member in members if isinstance(member, plan.FieldDeclaration)}
        open_fields = frozenset(field.name for field in fields.values() if self._is_open(field))
        return plan.Structure(type_, fields, members, latents, open_fields, span, is_modified)

    def _is_open(self, field: plan.FieldDeclaration) -> bool:
        """Return whether the value of a field is chosen unless it is given."""
        if field.default is not None:
            return False
        if isinstance(field.type, plan.StructType | plan.ActorType):  # a variable's fields may be parameters
            inner = self._expressions.program.structures.find(field.type)
            return inner is None or not inner.is_plain or bool(inner.open_fields)
        return not (field.is_variable or isinstance(field.type, plan.ListType))

    def _enter(self, field: symbols.FieldSymbol) -> None:
        """Elaborate the structure of a field's type."""
        if not isinstance(field.type, symbols.Structured) or self._defaults.of(field) is not None:
            return
        symbol = field.type.symbol
        if symbol in self._open:  # a cycle, which is reported when all structures are known
            return
        if len(self._open) >= MAX_DEPTH:
            self._refuse_depth(symbol)
        else:
            self.structure(symbol)

    def _measure(self, symbol: symbols.TypeSymbol) -> None:
        """Record the nesting of a type's values."""
        inner = [
            field.type.symbol
            for field in symbol.inventory.fields.values()
            if isinstance(field.type, symbols.Structured)
        ]
        self._depths[symbol] = 1 + max((self._depths.get(type_, 0) for type_ in inner), default=0)
        if self._depths[symbol] > MAX_DEPTH:
            self._refuse_depth(symbol)

    def _refuse_depth(self, symbol: symbols.TypeSymbol) -> None:
        """Report a type whose values are nested too deeply; later checks skip it."""
        self._expressions.bag.add(syntax.too_deep, symbol.span, MAX_DEPTH)
        symbol.is_open = True
        self._depths[symbol] = 0

    def _members(self, symbol: symbols.TypeSymbol) -> Iterator[plan.StructureMember]:
        """Yield the additions of a type to its base: condition, members, and members of extensions."""
        if symbol.condition is not None:
            yield self._fixed(symbol.condition, symbol.span)
        for part in symbol.parts:
            scope = scope_of(symbol, part.home)
            for member in part.members:
                match member:
                    case ast.ParameterDeclaration(field_names, constraints=constraints):
                        for field in declared(symbol, field_names):
                            yield self._field(field)
                            it = plan.Field(field.name, field.span)
                            yield from self._with_block(constraints, scope, field, it)
                    case ast.VariableDeclaration(field_names):
                        yield from (self._field(field) for field in declared(symbol, field_names))
                    case ast.KeepConstraint() | ast.RemoveDefault():
                        yield from self._constraints.among((member,), scope)
                    case _:
                        pass

    def _with_block(
        self,
        constraints: tuple[ast.ConstraintDeclaration | ast.InvalidStatement, ...],
        scope: Scope,
        field: symbols.FieldSymbol,
        it: plan.Expression,
    ) -> Iterable[plan.ConstraintMember]:
        """Return the constraints on a field, in which `it` is the field (7.3.6.1.1)."""
        if not constraints:
            return ()
        return self._constraints.among(constraints, replace(scope, it=field.type, it_value=it))

    def _fixed(self, condition: symbols.Condition, span: Span) -> plan.Constraint:
        """Build the constraint of a conditional subtype on its deciding field."""
        literal = plan.Literal(_condition_value(condition), span)
        return plan.Constraint(
            plan.Compare("==", plan.Field(condition.field.name, span), literal, span), False, span
        )

    def _field(self, field: symbols.FieldSymbol) -> plan.FieldDeclaration:
        type_ = plan_type(field.type, self._expressions.program)
        return plan.FieldDeclaration(field.name, type_, self._defaults.of(field), field.is_variable, field.span)

    def _subtypes(self, symbol: symbols.TypeSymbol) -> list[symbols.TypeSymbol]:
        """Return the conditional subtypes that a value of a type may have, without its own."""
        if symbol in self._subtypes_of:
            return self._subtypes_of[symbol]
        decided, own = dict(self.conditions(symbol)), list(symbols.lineage(symbol))
        found = self._subtypes_of[symbol] = []
        pending = deque(reversed(own))
        while pending:
            for name, by_value in self._by_condition.get(pending.popleft(), {}).items():
                fitting = (by_value.get(decided[name], []),) if name in decided else by_value.values()
                subtypes = [subtype for each in fitting for subtype in each if subtype not in own]
                found += subtypes
                pending += subtypes
        return found

    @cached_property
    def _by_condition(
        self,
    ) -> dict[symbols.TypeSymbol, dict[str, dict[bool | plan.EnumValue, list[symbols.TypeSymbol]]]]:
        """Group conditional subtypes by base, deciding field, and value."""
        found: dict[symbols.TypeSymbol, dict[str, dict[bool | plan.EnumValue, list[symbols.TypeSymbol]]]] = {}
        for symbol in self._expressions.program.conditionals:
            assert symbol.base is not None and symbol.condition is not None
            by_value = found.setdefault(symbol.base, {}).setdefault(symbol.condition.field.name, {})
            by_value.setdefault(_condition_value(symbol.condition), []).append(symbol)
        return found

    def _latent(self, symbol: symbols.TypeSymbol) -> plan.Latent:
        assert symbol.base is not None and symbol.condition is not None
        for field in symbol.fields.values():
            self._enter(field)
        condition = symbol.condition
        return plan.Latent(
            symbol.plan_name,
            symbol.base.plan_name,
            condition.field.name,
            _condition_value(condition),
            tuple(self._members(symbol)),
            symbol.span,
        )


def declared(symbol: symbols.TypeSymbol, field_names: tuple[ast.Name, ...]) -> Iterator[symbols.FieldSymbol]:
    """Yield the fields of one declaration with several names."""
    for name in field_names:
        yield from (
            field for field in symbol.inventory.fields.with_text(name.text).values() if field.span is name.span
        )


def _is_modified(symbol: symbols.TypeSymbol) -> bool:
    """Return whether a struct or an actor has modifiers."""
    parts = (part for type_ in symbols.lineage(symbol) for part in type_.parts)
    return symbol.kind in {symbols.Kind.STRUCT, symbols.Kind.ACTOR} and any(
        isinstance(member, ast.ModifierApplication) for part in parts for member in part.members
    )


def _condition_value(condition: symbols.Condition) -> bool | plan.EnumValue:
    if isinstance(condition.value, ast.BoolLiteral):
        return condition.value.value
    assert isinstance(condition.field.type, symbols.Enumeration), "checked with the condition"
    return enum_value(condition.field.type.symbol, condition.value.member.text)
