"""Implicit conversions (7.4.2.6, 7.4.2.3.1, 7.4.2.8.2) and common types (7.4.2.7.4)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final, NamedTuple

from seoro.lang import plan
from seoro.lang.arithmetic import INT_LIMITS, Number, wrap
from seoro.lang.check.plan_types import base_unit, type_name, units_of
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import listing, types
from seoro.lang.program import Program
from seoro.lang.source import Span
from seoro.lang.symbols import ListOf, Quantity, RangeOf, Structured, Type, TypeSymbol, lineage
from seoro.lang.types import FLOAT, INT, UINT, UNKNOWN, is_integer, is_known, is_number, is_plain_number
from seoro.lang.units import unit_text

NUMBERS: Final[Mapping[Type, Number]] = {
    INT: Number.INT,
    UINT: Number.UINT,
    FLOAT: Number.FLOAT,
}


class Typed(NamedTuple):
    """An expression of the plan with its type; if that is Unknown, the expression is a placeholder."""

    expression: plan.Expression
    type: Type


def nothing(span: Span) -> Typed:
    """Create the placeholder of an invalid expression."""
    return Typed(plan.Literal(False, span), UNKNOWN)


def common_type(left: Type, right: Type) -> Type | None:
    """Return the common type of two values, or None."""
    if not is_known(left):
        return right
    if not is_known(right) or left == right:
        return left
    if is_integer(left) and is_integer(right):
        return INT
    if is_plain_number(left) and is_plain_number(right):
        return FLOAT
    match left, right:
        case Structured(first), Structured(second):
            shared = _common_base(first, second)
            return Structured(shared) if shared is not None else None
        case (ListOf(a) as whole, ListOf(b)) | (RangeOf(a) as whole, RangeOf(b)):
            inner = common_type(a, b)
            return type(whole)(inner) if inner is not None else None
        case _:
            return None


def _common_base(left: TypeSymbol, right: TypeSymbol) -> TypeSymbol | None:
    others = set(lineage(right))
    return next((symbol for symbol in lineage(left) if symbol in others), None)


class Converter:
    """Converts values to the types of the places where they are used.

    Args:
        program: The program.
        bag: Bag for messages.
        strict: Whether to report extensions to the standard.
    """

    def __init__(self, program: Program, bag: Bag, strict: bool) -> None:
        self._program = program
        self._bag = bag
        self._strict = strict

    def describe(self, type_: Type) -> str:
        """Describe a type for messages."""
        return type_name(type_, self._program)

    def convert(self, value: Typed, target: Type, context: str = "") -> plan.Expression:
        """Convert a value to the target type; report a mismatch.

        Args:
            value: The value.
            target: The expected type.
            context: Purpose of the value, for messages.
        """
        if not is_known(value.type) or not is_known(target):
            return value.expression
        found = self._try(value, target)
        if found is not None:
            return found
        self._report(value, target, context)
        return value.expression

    def _report(self, value: Typed, target: Type, context: str) -> None:
        hint = ""
        if isinstance(target, Quantity) and is_plain_number(value.type):
            unit = base_unit(target.dimension, self._program)
            hint = f"multiply it by a unit, such as `1{unit}`" if unit else ""
        elif isinstance(target, Quantity) and isinstance(value.expression, plan.Literal):
            units = units_of(target, self._program)
            hint = f"{self.describe(target)} has the units {listing(units[:4])}" if units else ""
        found, needed = self.describe(value.type), self.describe(target)
        self._bag.add(types.mismatch, value.expression.span, needed, found, context, hint)

    def _try(self, value: Typed, target: Type) -> plan.Expression | None:
        """Return the converted value; None if the types do not match."""
        source, expression = value.type, value.expression
        if is_integer(source) and is_integer(target):
            self._check_literal(expression, target)
        if source == target:
            return expression
        match source, target:
            case _, Quantity() if is_plain_number(source):
                return self._bare_number(expression, target)
            case _, _ if is_integer(source) and target in NUMBERS:
                return as_number(expression, NUMBERS[target])
            case Structured(symbol), Structured(base) if base in lineage(symbol):
                return expression
            case ListOf(a), ListOf(b):
                return self._list(expression, a, b)
            case RangeOf(a), RangeOf(b):
                return self._range(expression, a, b)
            case _, RangeOf(element) if is_number(source):
                bound = self._try(value, element)
                return None if bound is None else plan.RangeOf(bound, bound, expression.span)
            case _:
                return None

    def _check_literal(self, expression: plan.Expression, target: Type) -> None:
        if isinstance(expression, plan.Literal) and isinstance(expression.value, int):
            if target == UINT and expression.value < 0:
                self._bag.add(types.negative_uint, expression.span)
            elif target == INT and expression.value > INT_LIMITS[1]:
                self._bag.add(types.int_too_large, expression.span)

    def _bare_number(self, expression: plan.Expression, target: Quantity) -> plan.Expression | None:
        """Read a literal number without a unit in the SI base unit: an extension."""
        if not isinstance(expression, plan.Literal):
            return None
        if self._strict:
            self._bag.add(types.bare_number, expression.span, unit_text(target.dimension))
        return as_number(expression, Number.FLOAT)

    def _list(self, expression: plan.Expression, source: Type, target: Type) -> plan.Expression | None:
        if isinstance(expression, plan.ListOf):
            items = [self._try(Typed(item, source), target) for item in expression.items]
            done = [item for item in items if item is not None]
            return replace(expression, items=tuple(done)) if len(done) == len(items) else None
        return self._elementwise(expression, source, target)

    def _range(self, expression: plan.Expression, source: Type, target: Type) -> plan.Expression | None:
        if isinstance(expression, plan.RangeOf):
            low = self._try(Typed(expression.low, source), target)
            high = self._try(Typed(expression.high, source), target)
            return None if low is None or high is None else replace(expression, low=low, high=high)
        return self._elementwise(expression, source, target)

    def _elementwise(self, expression: plan.Expression, source: Type, target: Type) -> plan.Expression | None:
        """Convert a list or a range that is not a literal, as one of its elements; numbers stay numbers."""
        if isinstance(target, RangeOf) and not isinstance(source, RangeOf):
            return None
        return self._try(Typed(expression, source), target)


def adapted(value: Typed, target: Type) -> plan.Expression:
    """Convert integers, or lists or ranges of them, to another numeric type; return others unchanged.

    Args:
        value: The value.
        target: The same type except for the numeric type.
    """
    source, expression = value.type, value.expression
    while isinstance(source, ListOf | RangeOf) and isinstance(target, ListOf | RangeOf):
        source, target = source.element, target.element
    if source == target or not is_integer(source) or target not in NUMBERS:
        return expression
    return as_number(expression, NUMBERS[target])


def as_number(expression: plan.Expression, number: Number) -> plan.Expression:
    """Convert an integer, or a list or a range of integers, to another numeric type (7.4.2.3.1).

    Literals are converted immediately.
    """
    match expression:
        case plan.Literal(int(value), span):
            return plan.Literal(wrap(value, number), span)
        case plan.ListOf(items):
            return replace(expression, items=tuple(as_number(item, number) for item in items))
        case plan.RangeOf(low, high):
            return replace(expression, low=as_number(low, number), high=as_number(high, number))
        case _:
            return plan.Convert(expression, number, expression.span)
