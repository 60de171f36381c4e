"""What instances are made of, and values that are constructed: structs from arguments.

A field without a default takes the default value of its type, where there is one: a struct or an actor is
constructed, a list is empty, and numbers in the structs of `osc.types` are 0. Any other needs a value from
somewhere: an argument, a constraint, or, if it is a boolean or of an enumeration, from the seed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.check.arguments import bind
from seoro.lang.check.convert import Typed
from seoro.lang.check.plan_types import enum_value, plan_type
from seoro.lang.check.rewrite import names_used
from seoro.lang.check.scopes import Scope, scope_of
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import names, syntax
from seoro.lang.diagnostics import types as type_messages
from seoro.lang.source import Span
from seoro.lang.symbols import (
    Condition,
    FieldSymbol,
    Home,
    Kind,
    TypeSymbol,
    all_fields,
    is_open,
    lineage,
    may_lack_values,
)
from seoro.lang.types import (
    BOOL,
    FLOAT,
    STRING,
    UNKNOWN,
    Enumeration,
    ListOf,
    Quantity,
    RangeOf,
    Structured,
    Type,
    is_number,
)

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions

MAX_DEPTH = 50  # of values within values, which are made recursively
STANDARD_TYPES = "stdtypes"  # the namespace of `osc.types`
GLOBALS = "globals"  # what the structure of global parameters is called


class Values:
    """Elaborates structures, and constructs values.

    Args:
        expressions: For the expressions of arguments, defaults and constraints.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._structures: dict[TypeSymbol, plan.Structure] = {}
        self._open: list[TypeSymbol] = []
        self._asked: list[TypeSymbol] = []  # whose fields are being looked at for values
        self._depths: dict[TypeSymbol, int] = {}  # how many structures are within each other
        self._scopes: dict[tuple[TypeSymbol | None, Home], Scope] = {}
        self._defaults: dict[FieldSymbol, plan.Expression | None] = {}
        self._conditions: dict[TypeSymbol, tuple[tuple[str, bool | plan.EnumValue], ...]] = {}
        self._subtypes_of: dict[TypeSymbol, list[TypeSymbol]] = {}

    def from_arguments(self, symbol: TypeSymbol, node: ast.FunctionApplication, scope: Scope) -> Typed:
        """`name(arguments)`: other fields take their defaults."""
        fields = all_fields(symbol)
        given = bind(self._expressions, symbol.name, fields, node.arguments, scope, is_open(symbol))
        self.check_conditions(symbol, given, is_told_later=True)
        missing = self.lacking_of(symbol, given)
        if missing:
            self._expressions.bag.add(messages.MissingArgument(node.span, symbol.name, missing[0]))
        arguments = tuple((name, given[name]) for name in fields if name in given)
        type_ = symbol.plan_type
        assert isinstance(type_, plan.StructType)
        structures = self._expressions.program.structures
        return Typed(plan.Construct(type_, arguments, structures, node.span), Structured(symbol))

    # ------------------------------------------------------------ conditions (7.3.8.2)

    def conditions(self, symbol: TypeSymbol) -> tuple[tuple[str, bool | plan.EnumValue], ...]:
        """What the values of a conditional subtype hold in the fields that decide about it."""
        known = self._conditions.get(symbol)
        if known is None:
            conditions = [type_.condition for type_ in reversed(list(lineage(symbol)))]
            known = self._conditions[symbol] = tuple(
                (found.field.name, _condition_value(found)) for found in conditions if found is not None
            )
        return known

    def check_conditions(
        self, symbol: TypeSymbol, given: Mapping[str, plan.Expression], is_told_later: bool = False
    ) -> None:
        """Report what contradicts the conditions of a type.

        Args:
            symbol: The type.
            given: Values for its fields.
            is_told_later: Whether values that only the run tells are compared then.
        """
        for name, needed in self.conditions(symbol):
            value = given.get(name)
            if value is None or (is_told_later and not isinstance(value, plan.Literal)):
                continue
            if not isinstance(value, plan.Literal) or value.value != needed:
                shown = needed.member if isinstance(needed, plan.EnumValue) else str(needed).lower()
                message = type_messages.FixedByCondition(value.span, symbol.name, name, shown)
                self._expressions.bag.add(message)

    # ------------------------------------------------------------ what has no value

    def lacking_of(self, symbol: TypeSymbol, given: Mapping[str, object]) -> tuple[str, ...]:
        """Paths of the fields of a type that nothing gives a value, as far as the text tells."""
        if may_lack_values(symbol) or any(map(may_lack_values, self._subtypes(symbol))):
            return ()
        decided = {*given, *dict(self.conditions(symbol))}
        fields = [field for field in all_fields(symbol).values() if field.name not in decided]
        self._asked.append(symbol)
        found = tuple(path for field in fields for path in self.lacking(field))
        self._asked.pop()
        return found

    def lacking(self, field: FieldSymbol) -> tuple[str, ...]:
        """The paths of what a field lacks to have a value by itself."""
        if self.default(field) is not None or field.default is not None or field.is_variable:
            return ()
        match field.type:
            case Structured(symbol) if symbol in self._asked:
                return ()
            case Structured(symbol):
                return tuple(f"{field.name}.{path}" for path in self.lacking_of(symbol, {}))
            case ListOf() | Enumeration():
                return ()
            case type_ if type_ in (BOOL, UNKNOWN):
                return ()
            case _:
                return (field.name,)

    # ------------------------------------------------------------ structures

    def structure(self, symbol: TypeSymbol) -> plan.Structure:
        """What instances of a type are made of."""
        if symbol in self._structures:
            return self._structures[symbol]
        self._open.append(symbol)
        for field in all_fields(symbol).values():
            self._enter(field)
        self._measure(symbol)
        members = tuple(member for type_ in reversed(list(lineage(symbol))) for member in self._members(type_))
        latents = tuple(self._latent(subtype) for subtype in self._subtypes(symbol))
        made = self._made(symbol.plan_type, members, latents, symbol.span, _is_modified(symbol))
        self._open.pop()
        self._structures[symbol] = made
        self._expressions.program.structures.add(made)
        return made

    def globals(self) -> plan.Structure:
        """What the global parameters are made of (7.3.14)."""
        program = self._expressions.program
        members: list[plan.StructureMember] = []
        for declaration, home in program.global_declarations:
            for name in declaration.names:
                symbol = program.globals[home.namespace_of(name), name.text]
                if symbol.span is name.span:
                    self._enter(symbol)
                    members.append(self._field(symbol))
                    it = plan.Global(symbol.name, symbol.span)
                    members += self._with_block(declaration.constraints, self._scope(None, home), symbol, it)
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
        """Whether the value of a field has to be chosen if it is not given."""
        if field.default is not None:
            return False
        if isinstance(field.type, plan.StructType | plan.ActorType):  # a variable's fields may be parameters
            inner = self._expressions.program.structures.find(field.type)
            return inner is None or not inner.is_plain or bool(inner.open_fields)
        return not (field.is_variable or isinstance(field.type, plan.ListType))

    def _enter(self, field: FieldSymbol) -> None:
        """Elaborate the structure of what a field holds."""
        if not isinstance(field.type, Structured) or self.default(field) is not None:
            return
        symbol = field.type.symbol
        if symbol in self._open:  # a circle, which is reported when all structures are known
            return
        if len(self._open) >= MAX_DEPTH:
            self._refuse_depth(symbol)
        else:
            self.structure(symbol)

    def _measure(self, symbol: TypeSymbol) -> None:
        """Note how deep the values of a type are."""
        inner = [field.type.symbol for field in all_fields(symbol).values() if isinstance(field.type, Structured)]
        self._depths[symbol] = 1 + max((self._depths.get(type_, 0) for type_ in inner), default=0)
        if self._depths[symbol] > MAX_DEPTH:
            self._refuse_depth(symbol)

    def _refuse_depth(self, symbol: TypeSymbol) -> None:
        """Report a type whose values are too deep; nobody looks into it then."""
        self._expressions.bag.add(syntax.TooDeep(symbol.span, MAX_DEPTH))
        symbol.is_open = True
        self._depths[symbol] = 0

    def _members(self, symbol: TypeSymbol) -> Iterator[plan.StructureMember]:
        """What a type adds to its base: its condition, then its members and those of its extensions."""
        if symbol.condition is not None:
            yield self._fixed(symbol.condition, symbol.span)
        for part in symbol.parts:
            scope = self._scope(symbol, part.home)
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
                        found = self._expressions.constraints.member(member, scope)
                        if found is not None:
                            yield found
                    case _:
                        pass

    def _with_block(
        self,
        constraints: tuple[ast.ConstraintDeclaration | ast.InvalidStatement, ...],
        scope: Scope,
        field: FieldSymbol,
        it: plan.Expression,
    ) -> Iterator[plan.ConstraintMember]:
        """The constraints on a field, in which `it` is the field (7.3.6.1.1)."""
        if not constraints:
            return
        inside = replace(scope, it=field.type, it_value=it)
        for constraint in constraints:
            if not isinstance(constraint, ast.InvalidStatement):
                found = self._expressions.constraints.member(constraint, inside)
                if found is not None:
                    yield found

    def _fixed(self, condition: Condition, span: Span) -> plan.Constraint:
        """The constraint that a conditional subtype places on the field that decides about it."""
        literal = plan.Literal(_condition_value(condition), span)
        return plan.Constraint(
            plan.Compare("==", plan.Field(condition.field.name, span), literal, span), False, span
        )

    def _field(self, field: FieldSymbol) -> plan.FieldDeclaration:
        type_ = plan_type(field.type, self._expressions.program)
        return plan.FieldDeclaration(field.name, type_, self.default(field), field.is_variable, field.span)

    def _subtypes(self, symbol: TypeSymbol) -> list[TypeSymbol]:
        """The conditional subtypes, apart from its own, that a value of a type may be of."""
        if symbol in self._subtypes_of:
            return self._subtypes_of[symbol]
        decided, own = dict(self.conditions(symbol)), list(lineage(symbol))
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
    def _by_condition(self) -> dict[TypeSymbol, dict[str, dict[bool | plan.EnumValue, list[TypeSymbol]]]]:
        """Conditional subtypes by what they inherit, the field that decides, and its value."""
        found: dict[TypeSymbol, dict[str, dict[bool | plan.EnumValue, list[TypeSymbol]]]] = {}
        for symbol in self._expressions.program.conditionals:
            assert symbol.base is not None and symbol.condition is not None
            by_value = found.setdefault(symbol.base, {}).setdefault(symbol.condition.field.name, {})
            by_value.setdefault(_condition_value(symbol.condition), []).append(symbol)
        return found

    def _latent(self, symbol: TypeSymbol) -> plan.Latent:
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

    # ------------------------------------------------------------ defaults

    def default(self, field: FieldSymbol) -> plan.Expression | None:
        """The default value of a field, in the scope of its instance; None if it has none."""
        if field not in self._defaults:
            self._defaults[field] = None  # for defaults that construct what they are the default in
            self._defaults[field] = self._default(field)
        return self._defaults[field]

    def _default(self, field: FieldSymbol) -> plan.Expression | None:
        if field.default is not None:
            scope = self._scope(field.owner, field.home)
            return self._expressions.converted(field.default, field.type, scope, f"`{field.name}`")
        if field.is_variable:
            return self._initial(field)
        if is_number(field.type) and _is_standard_struct(field.owner):
            return plan.Literal(_zero(field.type), field.span)
        return None

    def _initial(self, field: FieldSymbol) -> plan.Expression | None:
        """What a variable holds before it gets a value: it always has one (7.3.6.1.2)."""
        span = field.span
        match field.type:
            case Enumeration(enum) if enum.members:
                return plan.Literal(enum_value(enum, next(iter(enum.members))), span)
            case ListOf():
                return plan.ListOf((), span)
            case RangeOf(element):
                zero = plan.Literal(_zero(element), span)
                return plan.RangeOf(zero, zero, span)
            case type_ if is_number(type_):
                return plan.Literal(_zero(type_), span)
            case type_ if type_ == BOOL:
                return plan.Literal(False, span)
            case type_ if type_ == STRING:
                return plan.Literal("", span)
            case _:
                return None

    def _scope(self, owner: TypeSymbol | None, home: Home) -> Scope:
        key = (owner, home)
        if key not in self._scopes:
            self._scopes[key] = scope_of(owner, home)
        return self._scopes[key]

    def check_order(self, fields: Mapping[str, FieldSymbol]) -> None:
        """Report default values that refer to each other in a circle."""
        given = {name: value for name, field in fields.items() if (value := self.default(field)) is not None}
        self.ordered(given, fields)

    def ordered(
        self, values: Mapping[str, plan.Expression], fields: Mapping[str, FieldSymbol]
    ) -> dict[str, plan.Expression]:
        """The values, each after those that it refers to; a circle is reported."""
        implementations = self._expressions.methods.implementations
        uses = {name: sorted(names_used(value, implementations) & values.keys()) for name, value in values.items()}
        done: dict[str, plan.Expression] = {}
        for first in values:
            path = {first: iter(uses[first])}  # each is needed by the one before it
            while path:
                name = next(reversed(path))
                needed = next((other for other in path[name] if other not in done), None)
                if needed is None:
                    done[name] = values[name]
                    path.popitem()
                elif needed in path:
                    order = list(path)
                    circle = (*order[order.index(needed) :], needed)
                    message = names.CyclicReference(fields[needed].span, "values of fields", circle)
                    self._expressions.bag.add(message)
                    return dict(values)
                else:
                    path[needed] = iter(uses[needed])
        return done


def declared(symbol: TypeSymbol, field_names: tuple[ast.Name, ...]) -> Iterator[FieldSymbol]:
    """The fields that a declaration of several names has added to a type."""
    for name in field_names:
        yield from (field for field in all_fields(symbol).called(name.text).values() if field.span is name.span)


def _is_modified(symbol: TypeSymbol) -> bool:
    """Whether modifiers are members of a struct or an actor."""
    parts = (part for type_ in lineage(symbol) for part in type_.parts)
    return symbol.kind in {Kind.STRUCT, Kind.ACTOR} and any(
        isinstance(member, ast.ModifierApplication) for part in parts for member in part.members
    )


def _is_standard_struct(symbol: TypeSymbol | None) -> bool:
    return symbol is not None and symbol.kind is Kind.STRUCT and symbol.namespace == STANDARD_TYPES


def _condition_value(condition: Condition) -> bool | plan.EnumValue:
    if isinstance(condition.value, ast.BoolLiteral):
        return condition.value.value
    assert isinstance(condition.field.type, Enumeration), "checked with the condition"
    return enum_value(condition.field.type.symbol, condition.value.member.text)


def _zero(type_: Type) -> int | float:
    return 0.0 if type_ == FLOAT or isinstance(type_, Quantity) else 0
