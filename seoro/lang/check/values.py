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
from seoro.lang.check.plan_types import struct_type
from seoro.lang.check.rewrite import fields_used
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import names
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol, Kind, TypeSymbol, all_fields, is_open, may_lack_values
from seoro.lang.types import FLOAT, ListOf, Quantity, Structured, Type, is_number

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions, Scope

STANDARD_TYPES = "stdtypes"  # the namespace of `osc.types`


@dataclass(frozen=True)
class Defaults:
    """The values that the fields of a type have by themselves.

    Args:
        values: In an order in which each can refer to the ones before it.
        missing: Paths of fields that have none.
    """

    values: Mapping[str, plan.Expression]
    missing: tuple[str, ...]


class Values:
    """Constructs values.

    Args:
        expressions: For the expressions of arguments and defaults.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._known: dict[TypeSymbol, Defaults] = {}
        self._open: list[TypeSymbol] = []
        self._scopes: dict[TypeSymbol, Scope] = {}
        self._of_fields: dict[FieldSymbol, tuple[plan.Expression | None, tuple[str, ...]]] = {}

    def from_arguments(self, symbol: TypeSymbol, node: ast.FunctionApplication, scope: Scope) -> Typed:
        """`name(arguments)`: other fields take their defaults."""
        fields = all_fields(symbol)
        given = bind(self._expressions, symbol.name, fields, node.arguments, scope, is_open(symbol))
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
        return plan.Construct(struct_type(symbol), arguments, rest, span), missing

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
        for field in all_fields(symbol).values():
            value, lacking = self.default(field)
            missing += lacking
            if value is not None:
                values[field.name] = value
        self._open.pop()
        found = Defaults(self.ordered(values, all_fields(symbol)), tuple(missing))
        self._known[symbol] = found
        return found

    def default(self, field: FieldSymbol) -> tuple[plan.Expression | None, tuple[str, ...]]:
        """The value that a field has by itself, and the paths of what lacks one."""
        if field not in self._of_fields:
            self._of_fields[field] = self._default(field)
        return self._of_fields[field]

    def _default(self, field: FieldSymbol) -> tuple[plan.Expression | None, tuple[str, ...]]:
        from seoro.lang.check.expressions import scope_of  # noqa: PLC0415 - they need each other

        if field.default is not None:
            scope = self._scopes.get(field.owner) or self._scopes.setdefault(field.owner, scope_of(field.owner))
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
        uses = {name: sorted(fields_used(value) & values.keys()) for name, value in values.items()}
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


def _is_standard_struct(symbol: TypeSymbol) -> bool:
    return symbol.kind is Kind.STRUCT and symbol.home.namespace == STANDARD_TYPES


def _zero(type_: Type) -> int | float:
    return 0.0 if type_ == FLOAT or isinstance(type_, Quantity) else 0
