"""Domains of the cells of scalars, by their types."""

from __future__ import annotations

from seoro.lang import solve
from seoro.lang.integers import UINT_LIMITS
from seoro.lang.plan import EnumType, EnumValue, PhysicalType, PrimitiveType, ValueType


def domain_of(type_: ValueType) -> solve.Domain | None:
    """Return the domain of a scalar; None for other types."""
    match type_:
        case PrimitiveType("bool"):
            return solve.Boolean()
        case PrimitiveType("int"):
            return solve.Integer()
        case PrimitiveType("uint"):
            return solve.Integer(*UINT_LIMITS)
        case PrimitiveType("float") | PhysicalType():
            return solve.Real()
        case PrimitiveType():
            return solve.Free()
        case EnumType(name, members):
            by_number = {number: EnumValue(name, member, number) for member, number in reversed(members)}
            return solve.Choice(tuple(reversed(by_number.values())))
        case _:
            return None
