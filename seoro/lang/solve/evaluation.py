"""Evaluation of terms and constraints with known cells, as in the runtime."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias, assert_never, cast

from seoro.lang.arithmetic import calculate, wrap
from seoro.lang.solve import terms
from seoro.lang.solve.terms import Cell, Value

_Step: TypeAlias = terms.Arithmetic | terms.Compare | terms.Implies
_STEPS: Final = (terms.Arithmetic, terms.Compare, terms.Implies)

# Tolerance of an equality of reals with a cell that was solved for, relative to the largest number in it. Each
# operation of 53-bit floats loses about 1e-16, so this suffices for long formulas.
TOLERANCE: Final = 1e-9

RELATIONS: Final[dict[str, Callable[[Any, Any], Any]]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def evaluate(term: terms.Term, values: Mapping[Cell, Value], tolerance: float = 0.0) -> Value:
    """Return the value of a term.

    Args:
        term: The term.
        values: The values of its cells.
        tolerance: Tolerance of equal reals, relative to the largest number in the equality.

    Raises:
        Unevaluable: The term has no value.
        KeyError: A cell has no value yet.
    """
    while isinstance(term, terms.IfThenElse):  # without recursion, since tables may be long
        term = term.then if evaluate(term.condition, values, tolerance) else term.otherwise
    match term:
        case terms.Const(value):
            return value
        case terms.CellRef(cell):
            return values[cell]
        case terms.Compare() | terms.Arithmetic() | terms.Implies():
            return _chain(term, values, tolerance)
        case terms.InRange(item, low, high):
            inside = _number(item, values)
            return _number(low, values) <= inside <= _number(high, values)
        case terms.InSet(item, members):
            return evaluate(item, values) in members
        case terms.Negate(operand, number):
            return wrap(-_number(operand, values), number)
        case terms.ToReal(operand):
            return float(_number(operand, values))
        case terms.ToWhole(operand, number):
            return wrap(_number(operand, values), number)
        case terms.Not(operand):
            return not evaluate(operand, values, tolerance)
        case terms.And(parts):
            return all(evaluate(part, values, tolerance) for part in parts)
        case terms.Or(parts):
            return any(evaluate(part, values, tolerance) for part in parts)
        case terms.Opaque():
            return term.evaluate(values)
        case _:
            assert_never(term)


def _chain(term: _Step, values: Mapping[Cell, Value], tolerance: float) -> Value:
    """Return the value of a chain of operations from its left end, without recursion, since chains may be long."""
    steps = [term]
    while isinstance(first := _first(steps[-1]), _STEPS):
        steps.append(first)
    value = evaluate(first, values, tolerance)
    for step in reversed(steps):
        match step:
            case terms.Arithmetic(operation, _, right, number):
                other = _number(right, values)
                try:
                    value = calculate(operation, cast(float, value), other, number)
                except ZeroDivisionError:
                    raise terms.Unevaluable("division of an integer by zero") from None
            case terms.Compare():
                value = _compared(step, value, values, tolerance)
            case terms.Implies(_, conclusion):
                value = not value or evaluate(conclusion, values, tolerance)
            case _:
                assert_never(step)
    return value


def _first(step: _Step) -> terms.Term:
    return step.premise if isinstance(step, terms.Implies) else step.left


def _compared(term: terms.Compare, left: Value, values: Mapping[Cell, Value], tolerance: float) -> bool:
    """Return whether a comparison with a known left side holds."""
    right = evaluate(term.right, values, tolerance)
    if RELATIONS[term.operator](left, right):
        return True
    return term.operator == "==" and tolerance > 0 and _close(term, left, right, values, tolerance)


def holds(term: terms.Term, values: Mapping[Cell, Value], tolerance: float = 0.0) -> bool:
    """Return whether a constraint holds; an unevaluable one does not."""
    try:
        return evaluate(term, values, tolerance) is True
    except terms.Unevaluable:
        return False


def _number(term: terms.Term, values: Mapping[Cell, Value]) -> float:
    return cast(float, evaluate(term, values))


def _close(term: terms.Compare, left: Value, right: Value, values: Mapping[Cell, Value], tolerance: float) -> bool:
    """Return whether two reals are equal except for rounding, relative to the numbers in the computation."""
    if not (isinstance(left, float) and isinstance(right, float) and math.isfinite(left - right)):
        return False
    scale = max(abs(left), abs(right))
    if abs(left - right) <= tolerance * scale:
        return True
    numbers = [
        evaluate(part, values)
        for part in terms.subterms(term)
        if not isinstance(part, terms.Compare | terms.Opaque)
    ]
    scale = max([scale, *(abs(found) for found in numbers if isinstance(found, float))])
    return math.isfinite(scale) and abs(left - right) <= tolerance * scale
