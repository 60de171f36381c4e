"""Comparison of two values of any type, by the language's operators (7.4.2.4)."""

from __future__ import annotations

import operator as operators
from collections.abc import Callable, Mapping
from typing import Any, Final

from seoro.lang.arithmetic import Number
from seoro.lang.plan import (
    ActorType,
    ListType,
    PhysicalType,
    PrimitiveType,
    RangeType,
    StructType,
    ValueType,
)
from seoro.runtime.values.conversions import to_number
from seoro.runtime.values.values import Value

RELATIONS: Final[Mapping[str, Callable[[Any, Any], bool]]] = {
    "==": operators.eq,
    "!=": operators.ne,
    "<": operators.lt,
    "<=": operators.le,
    ">": operators.gt,
    ">=": operators.ge,
}
_PLAIN_NUMBERS: Final = frozenset({"int", "uint", "float"})


class NotComparable(Exception):
    """Two values have no common type, or no order."""


def compare_values(
    left: Value, left_type: ValueType | None, operator: str, right: Value, right_type: ValueType | None
) -> bool:
    """Compare two values; numbers of different types are converted to a common one first.

    Args:
        left: The left value.
        left_type: Its static type; None if unknown.
        operator: One of `RELATIONS`.
        right: The right value.
        right_type: Its static type; None if unknown.

    Raises:
        NotComparable: They have no common type, or no order.
    """
    if left_type is not None and right_type is not None and left_type != right_type:
        number = _common_number(left_type, right_type)
        if number is not None:
            left, right = to_number(left, number), to_number(right, number)
    try:
        return RELATIONS[operator](left, right)
    except TypeError:
        raise NotComparable from None


def _common_number(left: ValueType, right: ValueType) -> Number | None:
    """Return the type to which numbers, also in lists and ranges, are converted; None for no conversion.

    Raises:
        NotComparable: The types have no common type.
    """
    match left, right:
        case (PrimitiveType(a), PrimitiveType(b)) if a == b:
            return None
        case (PrimitiveType(a), PrimitiveType(b)) if {a, b} <= _PLAIN_NUMBERS:
            return Number.FLOAT if "float" in (a, b) else Number.INT
        case (PhysicalType(unit=a), PhysicalType(unit=b)) if a == b:
            return None
        case (ListType(a), ListType(b)) | (RangeType(a), RangeType(b)):
            return _common_number(a, b)
        case (StructType() | ActorType(), StructType() | ActorType()):
            return None
        case _ if left == right:
            return None
        case _:
            raise NotComparable
