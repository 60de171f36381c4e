"""What each kind of term says about sets: of its value given its operands, and of its operands given its value.

Both err on the side of too much: a value that is possible is never lost. Together they contract the sets of a
constraint's terms, from the leaves up and from the root down (Benhamou and others, "Revising hull and box
consistency", 1999: HC4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import assert_never

from seoro.lang.integers import INT_LIMITS, UINT_LIMITS
from seoro.lang.solve import intervals
from seoro.lang.solve.sets import (
    ANYTHING,
    EITHER,
    FALSE,
    MISSING,
    REALS,
    TRUE,
    Anything,
    Empty,
    Finite,
    Range,
    ValueSet,
    between,
    contains,
    filtered,
    hull,
    is_whole,
    meet,
    only,
    single,
    union,
    without,
)
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
    Or,
    Relation,
    Term,
    ToReal,
    ToWhole,
    alike,
    other_whole,
)

Sets = Sequence[ValueSet]


def forward(term: Term, args: Sets, wrapping: bool) -> ValueSet:
    """What a term's value can be, given what its operands can be."""
    match term:
        case Compare(relation):
            return _compared(relation, args[0], args[1])
        case Arithmetic(operation, _, _, number):
            return intervals.combine(operation, _typed(args[0], number), _typed(args[1], number), number, wrapping)
        case Negate(_, number):
            return intervals.negate(_typed(args[0], number), number, wrapping)
        case ToReal():
            low, high = hull(args[0])
            return Range(float(low), float(high))
        case ToWhole(_, number):
            return intervals.converted(_typed(args[0], other_whole(number)), number, wrapping)
        case InRange():
            return _and((_compared("<=", args[1], args[0]), _compared("<=", args[0], args[2])))
        case InSet(_, values):
            return _among(args[0], values)
        case Not():
            return _not(args[0])
        case And():
            return _and(args)
        case Or():
            return _not(_and([_not(arg) for arg in args]))
        case Implies():
            return _not(_and((args[0], _not(args[1]))))
        case IfThenElse():
            if args[0] == TRUE:
                return args[1]
            return args[2] if args[0] == FALSE else union(args[1], args[2])
        case Opaque():
            return ANYTHING
        case Const(value):
            return single(value)
        case CellRef():
            raise AssertionError("cells are looked up")
        case _:
            assert_never(term)


def backward(term: Term, out: ValueSet, args: Sets, wrapping: bool) -> Sets:
    """What the operands of a term can be, given what its value can be.

    Raises:
        Empty: Nothing.
    """
    match term:
        case Compare(relation):
            return _relate(relation, args, out)
        case Arithmetic(operation, left, right, number):
            return _split(term, out, args, wrapping, squared=operation == "*" and alike(left, right))
        case Negate(_, number):
            return (intervals.negate(_typed(out, number), number, wrapping),)
        case ToReal():
            return (_whole(hull(out)),)
        case ToWhole(_, number):
            return (intervals.converted(_typed(out, number), other_whole(number), wrapping),)
        case InRange():
            return _inside(args, out)
        case InSet(_, values):
            return (_narrow_to(args[0], values, out),)
        case Not():
            return (_not(out),)
        case And():
            return _conjunction(args, out)
        case Or():
            return [_not(arg) for arg in _conjunction([_not(arg) for arg in args], _not(out))]
        case Implies():
            premise, refusal = _conjunction((args[0], _not(args[1])), _not(out))
            return premise, _not(refusal)
        case IfThenElse():
            return _branch(args, out)
        case Const() | CellRef() | Opaque():
            return args
        case _:
            assert_never(term)


def _typed(values: ValueSet, number: Number) -> Range:
    """An operand of arithmetic; of one that says nothing, its type does."""
    if isinstance(values, Anything) or values == REALS:
        match number:
            case Number.INT:
                return Range(*INT_LIMITS)
            case Number.UINT:
                return Range(*UINT_LIMITS)
            case Number.FLOAT:
                return REALS
            case _:
                assert_never(number)
    return hull(values)


def _whole(reals: Range) -> Range:
    """The whole numbers that can have become a real; large ones were rounded."""
    low = -math.inf if reals.low < -(2**53) else reals.low
    high = math.inf if reals.high > 2**53 else reals.high
    return between(low, high)


def _not(values: ValueSet) -> ValueSet:
    if values == TRUE:
        return FALSE
    return TRUE if values == FALSE else EITHER


def _and(args: Sets) -> ValueSet:
    if any(arg == FALSE for arg in args):
        return FALSE
    return TRUE if all(arg == TRUE for arg in args) else EITHER


def _conjunction(args: Sets, out: ValueSet) -> Sets:
    if out == TRUE:
        return [TRUE] * len(args)
    undecided = [index for index, arg in enumerate(args) if arg != TRUE]
    if out == FALSE and len(undecided) <= 1:
        if not undecided:
            raise Empty
        return [FALSE if index == undecided[0] else arg for index, arg in enumerate(args)]
    return args


def _split(term: Arithmetic, out: ValueSet, args: Sets, wrapping: bool, squared: bool) -> Sets:
    number = term.number
    result, left, right = (_typed(values, number) for values in (out, *args))
    if squared and not (wrapping and number is not Number.FLOAT):
        root = intervals.square_root(result, left, number)
        return root, root
    return intervals.split(term.operator, result, left, right, number, wrapping)


def _branch(args: Sets, out: ValueSet) -> Sets:
    condition, then, otherwise = args
    if condition == TRUE:
        return condition, meet(then, out), otherwise
    if condition == FALSE:
        return condition, then, meet(otherwise, out)
    if not _meets(then, out):
        return FALSE, then, meet(otherwise, out)
    if not _meets(otherwise, out):
        return TRUE, meet(then, out), otherwise
    return args


def _meets(one: ValueSet, other: ValueSet) -> bool:
    try:
        meet(one, other)
    except Empty:
        return False
    return True


def _among(item: ValueSet, values: tuple[object, ...]) -> ValueSet:
    if not any(contains(item, value) for value in values):
        return FALSE
    if isinstance(item, Finite) and all(value in values for value in item.values):
        return TRUE
    return TRUE if only(item) in values else EITHER


def _narrow_to(item: ValueSet, values: tuple[object, ...], out: ValueSet) -> ValueSet:
    if out == TRUE:
        return meet(item, filtered(tuple(dict.fromkeys(values)), lambda value: contains(item, value)))
    if out == FALSE:
        for value in values:
            item = without(item, value)
    return item


def _inside(args: Sets, out: ValueSet) -> Sets:
    item, low, high = args
    if out == TRUE:
        low, item = _relate("<=", (low, item), TRUE)
        item, high = _relate("<=", (item, high), TRUE)
    elif out == FALSE and _compared("<=", low, item) == TRUE:
        item, high = _relate("<=", (item, high), FALSE)
    elif out == FALSE and _compared("<=", item, high) == TRUE:
        low, item = _relate("<=", (low, item), FALSE)
    return item, low, high


_OPPOSITE: dict[Relation, Relation] = {"==": "!=", "!=": "==", "<": ">=", "<=": ">", ">": "<=", ">=": "<"}


def _compared(relation: Relation, left: ValueSet, right: ValueSet) -> ValueSet:
    """Whether a relation holds for all, none or some values of two sets."""
    match relation:
        case "==":
            return _equal(left, right)
        case "!=":
            return _not(_equal(left, right))
        case "<" | "<=":
            return _below(hull(left), hull(right), strict=relation == "<")
        case ">" | ">=":
            return _below(hull(right), hull(left), strict=relation == ">")


def _equal(left: ValueSet, right: ValueSet) -> ValueSet:
    one, other = only(left), only(right)
    if one is not MISSING and other is not MISSING:
        return TRUE if one == other else FALSE
    return EITHER if _meets(left, right) else FALSE


def _below(left: Range, right: Range, strict: bool) -> ValueSet:
    if left.high < right.low or (not strict and left.high <= right.low):
        return TRUE
    if left.low > right.high or (strict and left.low >= right.high):
        return FALSE
    return EITHER


def _relate(relation: Relation, args: Sets, out: ValueSet) -> Sets:
    """Both sides of a comparison that holds, or does not."""
    left, right = args
    if out != TRUE:
        return _relate(_OPPOSITE[relation], args, TRUE) if out == FALSE else args
    match relation:
        case "==":
            return meet(left, right), meet(right, left)
        case "!=":
            one, other = only(left), only(right)
            return (
                left if other is MISSING else without(left, other),
                right if one is MISSING else without(right, one),
            )
        case "<" | "<=":
            return _order(left, right, strict=relation == "<")
        case ">" | ">=":
            low, high = _order(right, left, strict=relation == ">")
            return high, low


def _order(low: ValueSet, high: ValueSet, strict: bool) -> Sets:
    """Two sides of which the first is smaller."""
    first, second = hull(low), hull(high)
    most = _step(second.high, second, -1) if strict else second.high
    least = _step(first.low, first, 1) if strict else first.low
    return meet(low, Range(-math.inf, most)), meet(high, Range(least, math.inf))


def _step(bound: float, values: Range, direction: int) -> float:
    """The next number that is strictly beyond a bound."""
    if is_whole(values):
        return bound + direction
    return bound if math.isinf(bound) else math.nextafter(bound, direction * math.inf)
