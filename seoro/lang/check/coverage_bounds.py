"""Values that constraints leave to a sampled parameter, for its default buckets (7.5.7).

Constraints are read as far as they compare the parameter with constants: `keep(it in [0..7])`,
`keep(count in [1, 2, 4])`, `keep(gap >= 1m and gap < 3m)`. Defaults can be overridden, and bound nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TypeAlias, TypeGuard

from seoro.lang import plan
from seoro.lang.arithmetic import Number
from seoro.lang.frozen import Value

Scalar: TypeAlias = bool | int | float | str | plan.EnumValue


class Bounds(Value):
    """Values that constraints leave.

    Args:
        low: Lower bound [SI base unit], infinite without one.
        high: Upper bound [SI base unit].
        values: Listed values; None without a list.
    """

    low: float = -math.inf
    high: float = math.inf
    values: tuple[Scalar, ...] | None = None

    @property
    def left(self) -> tuple[Scalar, ...] | None:
        """The listed values within the bounds; None without a list."""
        if self.values is None:
            return None
        return tuple(value for value in self.values if not is_a_number(value) or self.low <= value <= self.high)

    def within(self, other: Bounds) -> Bounds:
        """Return the values that both leave."""
        values = self.values if other.values is None else other.values
        if self.values is not None and other.values is not None:
            values = tuple(value for value in self.values if value in other.values)
        return Bounds(max(self.low, other.low), min(self.high, other.high), values)


def bounds_of(path: str, members: Iterable[plan.StructureMember], it: str | None) -> Bounds:
    """Return the values that the constraints among the members of a type leave to a parameter.

    Args:
        path: Path of the parameter, see `path_of`.
        members: The members.
        it: Field that `it` denotes; None if it is the instance.
    """
    found = Bounds()
    for member in members:
        if isinstance(member, plan.Constraint) and not member.is_default:
            for condition in _conjuncts(member.condition):
                found = _narrowed(found, condition, path, it)
    return found


def path_of(expression: plan.Expression, it: str | None) -> str | None:
    """Return the path of a parameter; None for other expressions.

    Args:
        expression: The expression.
        it: Field that `it` denotes; None if it is the instance.
    """
    match expression:
        case plan.Field(name):
            return name
        case plan.Binding("it") if it is not None:
            return it
        case plan.Member(plan.Self(), name):
            return name
        case plan.Member(base, name):
            around = path_of(base, it)
            return None if around is None else f"{around}.{name}"
        case _:
            return None


def _conjuncts(condition: plan.Expression) -> Iterator[plan.Expression]:
    if isinstance(condition, plan.Logic) and condition.operator == "and":
        yield from _conjuncts(condition.left)
        yield from _conjuncts(condition.right)
    else:
        yield condition


def _narrowed(found: Bounds, condition: plan.Expression, path: str, it: str | None) -> Bounds:
    match condition:
        case plan.Contains(item, plan.ListOf(items)) if path_of(item, it) == path:
            values = [_constant(each) for each in items]
            known = tuple(dict.fromkeys(value for value in values if value is not None))
            if len(known) < len(set(values)):  # one is not constant
                return found
            return found.within(Bounds(values=known))
        case plan.Contains(item, plan.RangeOf(first, last)) if path_of(item, it) == path:
            one, other = _number(first), _number(last)
            if one is None or other is None:
                return found
            return found.within(Bounds(min(one, other), max(one, other)))
        case plan.Compare("<" | "<=", left, right):
            return _compared(found, left, right, path, it)
        case plan.Compare(">" | ">=", left, right):
            return _compared(found, right, left, path, it)
        case _:
            return found


def _compared(found: Bounds, less: plan.Expression, greater: plan.Expression, path: str, it: str | None) -> Bounds:
    if path_of(less, it) == path:
        high = _number(greater)
        return found if high is None else found.within(Bounds(high=high))
    low = _number(less)
    return found.within(Bounds(low=low)) if path_of(greater, it) == path and low is not None else found


def _constant(expression: plan.Expression) -> Scalar | None:
    match expression:
        case plan.Literal(value):
            return value
        case plan.Convert(operand, number):
            value_ = _constant(operand)
            return float(value_) if number is Number.FLOAT and is_a_number(value_) else value_
        case plan.Negate(operand):
            negated = _number(operand)
            return None if negated is None else -negated
        case _:
            return None


def is_a_number(value: object) -> TypeGuard[int | float]:
    """Return whether a value is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _number(expression: plan.Expression) -> float | None:
    value = _constant(expression)
    return value if is_a_number(value) else None
