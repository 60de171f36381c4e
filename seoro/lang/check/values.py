"""Values that are constructed: structs from arguments, and structs and actors from the defaults of their fields.

A field without a default takes the default value of its type, where there is one: a struct or an actor is
constructed, a list is empty, and numbers in the structs of `osc.types` are 0. Any other needs a value from
somewhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.check.arguments import bind
from seoro.lang.check.convert import Typed
from seoro.lang.check.plan_types import enum_value, struct_type
from seoro.lang.check.rewrite import names_used
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import names
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
from seoro.lang.types import FLOAT, Enumeration, ListOf, Quantity, Structured, Type, is_number

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions, Scope

STANDARD_TYPES = "stdtypes"  # the namespace of `osc.types`


@dataclass(frozen=True)
class Defaults:
    """The values that the fields of a type have by themselves.

    Args:
        values: In an order in which each can refer to the ones before it.
        missing: Paths of fields that have none.
        latents: The conditional subtypes that a value may be of.
    """

    values: Mapping[str, plan.Expression]
    missing: tuple[str, ...]
    latents: tuple[plan.Latent, ...] = ()


class Values:
    """Constructs values.

    Args:
        expressions: For the expressions of arguments and defaults.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._known: dict[TypeSymbol, Defaults] = {}
        self._open: list[TypeSymbol] = []
        self._scopes: dict[tuple[TypeSymbol | None, Home], Scope] = {}
        self._of_fields: dict[FieldSymbol, tuple[plan.Expression | None, tuple[str, ...]]] = {}

    def from_arguments(self, symbol: TypeSymbol, node: ast.FunctionApplication, scope: Scope) -> Typed:
        """`name(arguments)`: other fields take their defaults."""
        fields = all_fields(symbol)
        given = bind(self._expressions, symbol.name, fields, node.arguments, scope, is_open(symbol))
        self.check_conditions(symbol, given, is_told_later=True)
        value, missing = self.construct(symbol, given, node.span)
        if missing and not may_lack_values(symbol):
            self._expressions.bag.add(messages.MissingArgument(node.span, symbol.name, missing[0]))
        return Typed(value, Structured(symbol))

    def construct(
        self, symbol: TypeSymbol, given: Mapping[str, plan.Expression], span: Span
    ) -> tuple[plan.Construct, tuple[str, ...]]:
        """A value of a struct or an actor, and the paths of those of its fields that have no value."""
        defaults = self.defaults(symbol)
        arguments = tuple((name, given[name]) for name in all_fields(symbol) if name in given)
        rest = tuple((name, value) for name, value in defaults.values.items() if name not in given)
        missing = tuple(path for path in defaults.missing if path.partition(".")[0] not in given)
        conditions = self.conditions(symbol)
        made = plan.Construct(struct_type(symbol), arguments, rest, conditions, defaults.latents, span)
        return made, missing

    def conditions(self, symbol: TypeSymbol) -> tuple[tuple[str, bool | plan.EnumValue], ...]:
        """What the values of a conditional subtype hold in the fields that decide about it (7.3.8.2)."""
        conditions = [type_.condition for type_ in reversed(list(lineage(symbol)))]
        return tuple((found.field.name, _condition_value(found)) for found in conditions if found is not None)

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

    def defaults(self, symbol: TypeSymbol) -> Defaults:
        """The default values of the fields of a type."""
        if symbol in self._known:
            return self._known[symbol]
        if symbol in self._open:
            path = (*(type_.name for type_ in self._open[self._open.index(symbol) :]), symbol.name)
            self._expressions.bag.add(messages.ContainsItself(symbol.span, path))
            return Defaults({}, ())
        self._open.append(symbol)
        values: dict[str, plan.Expression] = {}
        missing: list[str] = []
        decided = dict(self.conditions(symbol))
        for field in all_fields(symbol).values():
            if field.name in decided:
                values[field.name] = plan.Literal(decided[field.name], field.span)
                continue
            value, lacking = self.default(field)
            missing += lacking
            if value is not None:
                values[field.name] = value
        latents = tuple(self._latent(subtype) for subtype in self._subtypes(symbol))
        self._open.pop()
        found = Defaults(self.ordered(values, all_fields(symbol)), tuple(missing), latents)
        self._known[symbol] = found
        return found

    def _subtypes(self, symbol: TypeSymbol) -> list[TypeSymbol]:
        """The conditional subtypes, apart from its own, that a value of a type may be of."""
        own = list(lineage(symbol))
        found: list[TypeSymbol] = []
        for subtype in self._expressions.program.conditionals:
            assert subtype.base is not None
            if subtype not in own and (subtype.base in own or subtype.base in found):
                found.append(subtype)
        return found

    def _latent(self, symbol: TypeSymbol) -> plan.Latent:
        assert symbol.base is not None and symbol.condition is not None
        values: dict[str, plan.Expression] = {}
        missing: list[str] = []
        for field in symbol.fields.values():
            value, lacking = self.default(field)
            missing += lacking
            if value is not None:
                values[field.name] = value
        defaults = tuple(self.ordered(values, symbol.fields).items())
        condition = symbol.condition
        return plan.Latent(
            symbol.plan_name,
            symbol.base.plan_name,
            condition.field.name,
            _condition_value(condition),
            defaults,
            tuple(missing),
            symbol.span,
        )

    def default(self, field: FieldSymbol) -> tuple[plan.Expression | None, tuple[str, ...]]:
        """The value that a field has by itself, and the paths of what lacks one."""
        if field not in self._of_fields:
            self._of_fields[field] = self._default(field)
        return self._of_fields[field]

    def _default(self, field: FieldSymbol) -> tuple[plan.Expression | None, tuple[str, ...]]:
        from seoro.lang.check.expressions import scope_of  # noqa: PLC0415 - they need each other

        if field.default is not None:
            key = (field.owner, field.home)
            scope = self._scopes.get(key) or self._scopes.setdefault(key, scope_of(*key))
            return self._expressions.converted(field.default, field.type, scope, f"`{field.name}`"), ()
        return self._default_of_type(field)

    def _default_of_type(self, field: FieldSymbol) -> tuple[plan.Expression | None, tuple[str, ...]]:
        span = field.span
        match field.type:
            case Structured(symbol):
                value, missing = self.construct(symbol, {}, span)
                return value, tuple(f"{field.name}.{path}" for path in missing)
            case ListOf():
                return plan.ListOf((), span), ()
            case number if is_number(number) and _is_standard_struct(field.owner):
                return plan.Literal(_zero(number), span), ()
            case _:
                return None, (field.name,)

    def ordered(
        self, values: Mapping[str, plan.Expression], fields: Mapping[str, FieldSymbol]
    ) -> dict[str, plan.Expression]:
        """The values, each after those that it refers to; a circle is reported."""
        implementations = self._expressions.methods.implementations
        uses = {name: sorted(names_used(value, implementations) & values.keys()) for name, value in values.items()}
        done: dict[str, plan.Expression] = {}
        for first in values:
            path = [first]  # each is needed by the one before it
            while path:
                name = path[-1]
                needed = next((other for other in uses[name] if other not in done), None)
                if needed is None:
                    done[name] = values[name]
                    path.pop()
                elif needed in path:
                    circle = (*path[path.index(needed) :], needed)
                    message = names.CyclicReference(fields[needed].span, "values of fields", circle)
                    self._expressions.bag.add(message)
                    return dict(values)
                else:
                    path.append(needed)
        return done


def _is_standard_struct(symbol: TypeSymbol | None) -> bool:
    return symbol is not None and symbol.kind is Kind.STRUCT and symbol.namespace == STANDARD_TYPES


def _condition_value(condition: Condition) -> bool | plan.EnumValue:
    if isinstance(condition.value, ast.BoolLiteral):
        return condition.value.value
    assert isinstance(condition.field.type, Enumeration), "checked with the condition"
    return enum_value(condition.field.type.symbol, condition.value.member.text)


def _zero(type_: Type) -> int | float:
    return 0.0 if type_ == FLOAT or isinstance(type_, Quantity) else 0
