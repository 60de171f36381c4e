"""The value of a term whose cells have values, as the runtime computes it, and whether a constraint holds."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias, assert_never, cast

from seoro.lang.integers import wrap_int, wrap_uint
from seoro.lang.solve.cells import Cell, Value
from seoro.lang.solve.terms import (
    And,
    Arithmetic,
    CellRef,
    Compare,
    Const,
    IfThenElse,
    Implies,
    InRange,
    InSet,
    Negate,
    Not,
    Number,
    Opaque,
    Operation,
    Or,
    Term,
    ToReal,
    ToWhole,
    Unevaluable,
    subterms,
)

_Step: TypeAlias = Arithmetic | Compare | Implies
_STEPS: Final = (Arithmetic, Compare, Implies)

# How far apart, relative to the largest number in it, the sides of an equality of reals may be when a cell had to
# be solved for. Floats of 53 bits lose about 1e-16 in each operation: this leaves room for long formulas.
TOLERANCE: Final = 1e-9

_RELATIONS: Final[dict[str, Callable[[Any, Any], bool]]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def evaluate(term: Term, values: Mapping[Cell, Value], tolerance: float = 0.0) -> Value:
    """The value of a term.

    Args:
        term: The term.
        values: The values of its cells.
        tolerance: How far apart equal reals may be, relative to the largest number in the equality.

    Raises:
        Unevaluable: It has none.
        KeyError: A cell has no value yet.
    """
    while isinstance(term, IfThenElse):  # a table is long on its last branch, so it is no recursion
        term = term.then if evaluate(term.condition, values, tolerance) else term.otherwise
    match term:
        case Const(value):
            return value
        case CellRef(cell):
            return values[cell]
        case Compare() | Arithmetic() | Implies():
            return _chain(term, values, tolerance)
        case InRange(item, low, high):
            inside = _number(item, values)
            return _number(low, values) <= inside <= _number(high, values)
        case InSet(item, members):
            return evaluate(item, values) in members
        case Negate(operand, number):
            return wrap(-_number(operand, values), number)
        case ToReal(operand):
            return float(_number(operand, values))
        case ToWhole(operand, number):
            return wrap(_number(operand, values), number)
        case Not(operand):
            return not evaluate(operand, values, tolerance)
        case And(parts):
            return all(evaluate(part, values, tolerance) for part in parts)
        case Or(parts):
            return any(evaluate(part, values, tolerance) for part in parts)
        case Opaque():
            return term.evaluate(values)
        case _:
            assert_never(term)


def _chain(term: _Step, values: Mapping[Cell, Value], tolerance: float) -> Value:
    """The value of a chain of operations, from its left end: chains may be long, so they are no recursion."""
    steps = [term]
    while isinstance(first := _first(steps[-1]), _STEPS):
        steps.append(first)
    value = evaluate(first, values, tolerance)
    for step in reversed(steps):
        match step:
            case Arithmetic(operation, _, right, number):
                value = calculate(operation, cast(float, value), _number(right, values), number)
            case Compare():
                value = _compared(step, value, values, tolerance)
            case Implies(_, conclusion):
                value = not value or evaluate(conclusion, values, tolerance)
            case _:
                assert_never(step)
    return value


def _first(step: _Step) -> Term:
    return step.premise if isinstance(step, Implies) else step.left


def _compared(term: Compare, left: Value, values: Mapping[Cell, Value], tolerance: float) -> bool:
    """Whether a comparison holds whose left side is known."""
    right = evaluate(term.right, values, tolerance)
    if _RELATIONS[term.operator](left, right):
        return True
    return term.operator == "==" and tolerance > 0 and _close(term, left, right, values, tolerance)


def holds(term: Term, values: Mapping[Cell, Value], tolerance: float = 0.0) -> bool:
    """Whether a constraint holds; one that cannot be evaluated does not."""
    try:
        return evaluate(term, values, tolerance) is True
    except Unevaluable:
        return False


def calculate(operation: Operation, left: float, right: float, number: Number) -> int | float:
    """The result of an operation on two numbers.

    Raises:
        Unevaluable: An integer is divided by zero.
    """
    match operation:
        case "+":
            return wrap(left + right, number)
        case "-":
            return wrap(left - right, number)
        case "*":
            return wrap(left * right, number)
        case "/" | "%":
            return _divide(operation, left, right, number)
        case _:
            assert_never(operation)


def wrap(value: float, number: Number) -> int | float:
    """A result as its type holds it: in 64 bits, signed or not, or as a float."""
    match number:
        case Number.INT:
            return wrap_int(int(value))
        case Number.UINT:
            return wrap_uint(int(value))
        case Number.FLOAT:
            return float(value)
        case _:
            assert_never(number)


def _divide(operation: Operation, left: float, right: float, number: Number) -> int | float:
    if number is Number.FLOAT:
        return _remainder(left, right) if operation == "%" else _quotient(left, right)
    if right == 0:
        raise Unevaluable("division of an integer by zero")
    quotient = int(abs(left)) // int(abs(right))
    if (left < 0) != (right < 0):
        quotient = -quotient
    return wrap(quotient if operation == "/" else left - quotient * right, number)


def _quotient(left: float, right: float) -> float:
    if right != 0:
        return left / right
    if left == 0 or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)


def _remainder(left: float, right: float) -> float:
    return math.nan if right == 0 or math.isinf(left) else math.fmod(left, right)


def _number(term: Term, values: Mapping[Cell, Value]) -> float:
    return cast(float, evaluate(term, values))


def _close(term: Compare, left: Value, right: Value, values: Mapping[Cell, Value], tolerance: float) -> bool:
    """Whether two reals are equal but for rounding, which is as large as the numbers that were computed with."""
    if not (isinstance(left, float) and isinstance(right, float) and math.isfinite(left - right)):
        return False
    scale = max(abs(left), abs(right))
    if abs(left - right) <= tolerance * scale:
        return True
    numbers = [evaluate(part, values) for part in subterms(term) if not isinstance(part, Compare | Opaque)]
    scale = max([scale, *(abs(found) for found in numbers if isinstance(found, float))])
    return math.isfinite(scale) and abs(left - right) <= tolerance * scale
