"""Default values of fields, and the order in which they are computed.

A field without a default takes that of its type, if any: numbers in the structs of `osc.types` are 0, and
variables always hold a value.

Values of a type may not contain themselves without end, by fields or by constructed defaults. Fields that hold
actors are exempt: constraints may refer them to existing actors.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice

from seoro.lang import plan
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.methods import Methods
from seoro.lang.check.plan_types import enum_value
from seoro.lang.check.scopes import scope_of
from seoro.lang.check.traversal import circles, names_used
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import names
from seoro.lang.symbols import Enumeration, FieldSymbol, Kind, ListOf, Quantity, RangeOf, Type, TypeSymbol
from seoro.lang.types import BOOL, FLOAT, STRING, is_number

STANDARD_TYPES = "stdtypes"  # the namespace of `osc.types`


class Defaults:
    """Elaborates default values.

    Args:
        expressions: The expression checker.
        methods: The methods that defaults may call.
    """

    def __init__(self, expressions: ExpressionChecker, methods: Methods) -> None:
        self._expressions = expressions
        self._methods = methods
        self._known: dict[FieldSymbol, plan.Expression | None] = {}

    def of(self, field: FieldSymbol) -> plan.Expression | None:
        """Return the default value of a field, in the scope of its instance, or None."""
        if field not in self._known:
            self._known[field] = None  # while it is elaborated: a default may construct its own type
            self._known[field] = self._default(field)
        return self._known[field]

    def _default(self, field: FieldSymbol) -> plan.Expression | None:
        if field.default is not None:
            scope = scope_of(field.owner, field.home)
            return self._expressions.converted(field.default, field.type, scope, f"`{field.name}`")
        if field.is_variable:
            return self._initial(field)
        if is_number(field.type) and _is_standard_struct(field.owner):
            return plan.Literal(_zero(field.type), field.span)
        return None

    def _initial(self, field: FieldSymbol) -> plan.Expression | None:
        """Return the initial value of a variable, which always has one (7.3.6.1.2)."""
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

    def check_order(self, fields: Mapping[str, FieldSymbol]) -> None:
        """Report default values that refer to each other in a cycle."""
        values = {name: value for name, field in fields.items() if (value := self.of(field)) is not None}
        uses = {name: sorted(self._names_used(value) & values.keys()) for name, value in values.items()}
        for circle in islice(circles(uses), 1):
            self._expressions.bag.add(names.cyclic_reference, fields[circle[0]].span, "values of fields", circle)

    def _names_used(self, value: plan.Expression) -> set[str]:
        return names_used(value, self._methods.implementations, self._expressions.program.structures)


def _is_standard_struct(symbol: TypeSymbol | None) -> bool:
    return symbol is not None and symbol.kind is Kind.STRUCT and symbol.namespace == STANDARD_TYPES


def _zero(type_: Type) -> int | float:
    return 0.0 if type_ == FLOAT or isinstance(type_, Quantity) else 0


def check_containment(structures: plan.Structures, bag: Bag) -> None:
    """Report each cycle of types that contain one another, once."""
    done: set[str] = set()
    for structure in sorted(structures.all(), key=lambda each: (each.span.file.name, each.span.start)):
        path = [structure]
        branches = [_contained(structure, structures)]
        while path:
            inner = next(branches[-1], None)
            if inner is None:
                done.add(path.pop().type.name)
                branches.pop()
            elif inner in path:
                circle = [*path[path.index(inner) :], inner]
                bag.add(messages.contains_itself, inner.span, tuple(each.type.name for each in circle))
                done.update(each.type.name for each in path)
            elif inner.type.name not in done:
                path.append(inner)
                branches.append(_contained(inner, structures))


def _contained(structure: plan.Structure, structures: plan.Structures) -> Iterator[plan.Structure]:
    """Yield the structures that every value of a structure contains."""
    for field in structure.fields.values():
        pending = [field.default] if field.default is not None else []
        while pending:
            current = pending.pop()
            if isinstance(current, plan.Construct):
                yield structures.of(current.type)
            pending += plan.parts(current)
        if field.default is None and isinstance(field.type, plan.StructType):
            inner = structures.find(field.type)
            if inner is not None:
                yield inner
