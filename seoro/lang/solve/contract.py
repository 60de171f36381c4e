"""Contraction of sets of values by each kind of term: `forward` to its value, `backward` to its operands.

Sets may be too large, but never lack a possible value. Together, both contract the sets of the terms of a
constraint, from the leaves up and from the root down (Benhamou and others, "Revising hull and box consistency",
1999: HC4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import assert_never

from seoro.lang.arithmetic import Number
from seoro.lang.solve import intervals, sets, terms

Sets = Sequence[sets.ValueSet]


def forward(term: terms.Term, args: Sets, wrapping: bool) -> sets.ValueSet:
    """Return the possible values of a term, given those of its operands."""
    match term:
        case terms.Compare(relation):
            return _compared(relation, args[0], args[1])
        case terms.Arithmetic(operation, _, _, number):
            return intervals.combine(operation, _typed(args[0], number), _typed(args[1], number), number, wrapping)
        case terms.Negate(_, number):
            return intervals.negate(_typed(args[0], number), number, wrapping)
        case terms.ToReal():
            low, high = sets.hull(args[0])
            return sets.Range(float(low), float(high))
        case terms.ToWhole(_, number):
            return intervals.converted(_typed(args[0], terms.other_whole(number)), number, wrapping)
        case terms.InRange():
            return _and((_compared("<=", args[1], args[0]), _compared("<=", args[0], args[2])))
        case terms.InSet(_, values):
            return _among(args[0], values)
        case terms.Not():
            return _not(args[0])
        case terms.And():
            return _and(args)
        case terms.Or():
            return _not(_and([_not(arg) for arg in args]))
        case terms.Implies():
            return _not(_and((args[0], _not(args[1]))))
        case terms.IfThenElse():
            if args[0] == sets.TRUE:
                return args[1]
            return args[2] if args[0] == sets.FALSE else sets.union(args[1], args[2])
        case terms.Opaque():
            return sets.ANYTHING
        case terms.Const(value):
            return sets.single(value)
        case terms.CellRef():
            raise AssertionError("cells are looked up")
        case _:
            assert_never(term)


def backward(term: terms.Term, out: sets.ValueSet, args: Sets, wrapping: bool) -> Sets:
    """Return the possible values of the operands of a term, given those of the term.

    Raises:
        Empty: An operand has no possible value.
    """
    match term:
        case terms.Compare(relation):
            return _relate(relation, args, out)
        case terms.Arithmetic(operation, left, right, number):
            return _split(term, out, args, wrapping, squared=operation == "*" and terms.alike(left, right))
        case terms.Negate(_, number):
            return (intervals.negate(_typed(out, number), number, wrapping),)
        case terms.ToReal():
            return (_whole(sets.hull(out)),)
        case terms.ToWhole(_, number):
            return (intervals.converted(_typed(out, number), terms.other_whole(number), wrapping),)
        case terms.InRange():
            return _inside(args, out)
        case terms.InSet(_, values):
            return (_narrow_to(args[0], values, out),)
        case terms.Not():
            return (_not(out),)
        case terms.And():
            return _conjunction(args, out)
        case terms.Or():
            return [_not(arg) for arg in _conjunction([_not(arg) for arg in args], _not(out))]
        case terms.Implies():
            premise, refusal = _conjunction((args[0], _not(args[1])), _not(out))
            return premise, _not(refusal)
        case terms.IfThenElse():
            return _branch(args, out)
        case terms.Const() | terms.CellRef() | terms.Opaque():
            return args
        case _:
            assert_never(term)


def _typed(values: sets.ValueSet, number: Number) -> sets.Range:
    """Return the range of an arithmetic operand, by default that of its type."""
    unknown = isinstance(values, sets.Anything) or values == sets.REALS
    return intervals.LIMITS[number] if unknown else sets.hull(values)


def _whole(reals: sets.Range) -> sets.Range:
    """Return the integers that convert to a range of reals; large ones are rounded."""
    low = -math.inf if reals.low < -(2**53) else reals.low
    high = math.inf if reals.high > 2**53 else reals.high
    return sets.between(low, high)


def _not(values: sets.ValueSet) -> sets.ValueSet:
    if values == sets.TRUE:
        return sets.FALSE
    return sets.TRUE if values == sets.FALSE else sets.EITHER


def _and(args: Sets) -> sets.ValueSet:
    if any(arg == sets.FALSE for arg in args):
        return sets.FALSE
    return sets.TRUE if all(arg == sets.TRUE for arg in args) else sets.EITHER


def _conjunction(args: Sets, out: sets.ValueSet) -> Sets:
    if out == sets.TRUE:
        return [sets.TRUE] * len(args)
    undecided = [index for index, arg in enumerate(args) if arg != sets.TRUE]
    if out == sets.FALSE and len(undecided) <= 1:
        if not undecided:
            raise sets.Empty
        return [sets.FALSE if index == undecided[0] else arg for index, arg in enumerate(args)]
    return args


def _split(term: terms.Arithmetic, out: sets.ValueSet, args: Sets, wrapping: bool, squared: bool) -> Sets:
    number = term.number
    result, left, right = (_typed(values, number) for values in (out, *args))
    if squared and not (wrapping and number is not Number.FLOAT):
        root = intervals.square_root(result, left, number)
        return root, root
    return intervals.split(term.operator, result, left, right, number, wrapping)


def _branch(args: Sets, out: sets.ValueSet) -> Sets:
    condition, then, otherwise = args
    if condition == sets.TRUE:
        return condition, sets.meet(then, out), otherwise
    if condition == sets.FALSE:
        return condition, then, sets.meet(otherwise, out)
    if not _meets(then, out):
        return sets.FALSE, then, sets.meet(otherwise, out)
    if not _meets(otherwise, out):
        return sets.TRUE, sets.meet(then, out), otherwise
    return args


def _meets(one: sets.ValueSet, other: sets.ValueSet) -> bool:
    try:
        sets.meet(one, other)
    except sets.Empty:
        return False
    return True


def _among(item: sets.ValueSet, values: tuple[object, ...]) -> sets.ValueSet:
    if not any(sets.contains(item, value) for value in values):
        return sets.FALSE
    if isinstance(item, sets.Finite) and all(value in values for value in item.values):
        return sets.TRUE
    return sets.TRUE if sets.only(item) in values else sets.EITHER


def _narrow_to(item: sets.ValueSet, values: tuple[object, ...], out: sets.ValueSet) -> sets.ValueSet:
    if out == sets.TRUE:
        return sets.meet(
            item, sets.filtered(tuple(dict.fromkeys(values)), lambda value: sets.contains(item, value))
        )
    if out == sets.FALSE:
        for value in values:
            item = sets.without(item, value)
    return item


def _inside(args: Sets, out: sets.ValueSet) -> Sets:
    item, low, high = args
    if out == sets.TRUE:
        low, item = _relate("<=", (low, item), sets.TRUE)
        item, high = _relate("<=", (item, high), sets.TRUE)
    elif out == sets.FALSE and _compared("<=", low, item) == sets.TRUE:
        item, high = _relate("<=", (item, high), sets.FALSE)
    elif out == sets.FALSE and _compared("<=", item, high) == sets.TRUE:
        low, item = _relate("<=", (low, item), sets.FALSE)
    return item, low, high


_OPPOSITE: dict[terms.Relation, terms.Relation] = {
    "==": "!=",
    "!=": "==",
    "<": ">=",
    "<=": ">",
    ">": "<=",
    ">=": "<",
}


def _compared(relation: terms.Relation, left: sets.ValueSet, right: sets.ValueSet) -> sets.ValueSet:
    """Return whether a relation holds for all, none or some values of two sets."""
    match relation:
        case "==":
            return _equal(left, right)
        case "!=":
            return _not(_equal(left, right))
        case "<" | "<=":
            return _below(sets.hull(left), sets.hull(right), strict=relation == "<")
        case ">" | ">=":
            return _below(sets.hull(right), sets.hull(left), strict=relation == ">")


def _equal(left: sets.ValueSet, right: sets.ValueSet) -> sets.ValueSet:
    one, other = sets.only(left), sets.only(right)
    if one is not sets.MISSING and other is not sets.MISSING:
        return sets.TRUE if one == other else sets.FALSE
    return sets.EITHER if _meets(left, right) else sets.FALSE


def _below(left: sets.Range, right: sets.Range, strict: bool) -> sets.ValueSet:
    if left.high < right.low or (not strict and left.high <= right.low):
        return sets.TRUE
    if left.low > right.high or (strict and left.low >= right.high):
        return sets.FALSE
    return sets.EITHER


def _relate(relation: terms.Relation, args: Sets, out: sets.ValueSet) -> Sets:
    """Contract both sides of a comparison with a given result."""
    left, right = args
    if out != sets.TRUE:
        return _relate(_OPPOSITE[relation], args, sets.TRUE) if out == sets.FALSE else args
    match relation:
        case "==":
            return sets.meet(left, right), sets.meet(right, left)
        case "!=":
            one, other = sets.only(left), sets.only(right)
            return (
                left if other is sets.MISSING else sets.without(left, other),
                right if one is sets.MISSING else sets.without(right, one),
            )
        case "<" | "<=":
            return _order(left, right, strict=relation == "<")
        case ">" | ">=":
            low, high = _order(right, left, strict=relation == ">")
            return high, low


def _order(low: sets.ValueSet, high: sets.ValueSet, strict: bool) -> Sets:
    """Contract two sides of which the first is smaller."""
    first, second = sets.hull(low), sets.hull(high)
    most = _step(second.high, second, -1) if strict else second.high
    least = _step(first.low, first, 1) if strict else first.low
    return sets.meet(low, sets.Range(-math.inf, most)), sets.meet(high, sets.Range(least, math.inf))


def _step(bound: float, values: sets.Range, direction: int) -> float:
    """Return the next number beyond a bound."""
    if sets.is_whole(values):
        return bound + direction
    return bound if math.isinf(bound) else math.nextafter(bound, direction * math.inf)
