"""Built-in types, and the predicates of types; `symbols.py` has the types themselves."""

from __future__ import annotations

from typing import Final

from seoro.lang.symbols import ListOf, Primitive, Quantity, RangeOf, Type, Unknown
from seoro.lang.units import DIMENSIONLESS, Dimension

BOOL: Final = Primitive("bool")
INT: Final = Primitive("int")
UINT: Final = Primitive("uint")
FLOAT: Final = Primitive("float")
STRING: Final = Primitive("string")
UNKNOWN: Final = Unknown()
_INTEGERS: Final = frozenset({"int", "uint"})
_PLAIN_NUMBERS: Final = _INTEGERS | {"float"}
PRIMITIVES: Final = {type_.name: type_ for type_ in (BOOL, INT, UINT, FLOAT, STRING)}


def is_integer(type_: Type) -> bool:
    """Return whether a type is `int` or `uint`."""
    return isinstance(type_, Primitive) and type_.name in _INTEGERS


def is_plain_number(type_: Type) -> bool:
    """Return whether a type is a number without a dimension."""
    return isinstance(type_, Primitive) and type_.name in _PLAIN_NUMBERS


def is_number(type_: Type) -> bool:
    """Return whether a type is a number, with or without a dimension."""
    return is_plain_number(type_) or isinstance(type_, Quantity)


def quantity(dimension: Dimension) -> Type:
    """Return the type of values of a dimension; `float` without dimension."""
    return FLOAT if dimension == DIMENSIONLESS else Quantity(dimension)


def dimension_of(type_: Type) -> Dimension:
    """Return the dimension of a numeric type."""
    return type_.dimension if isinstance(type_, Quantity) else DIMENSIONLESS


def is_known(type_: Type) -> bool:
    """Return whether a type has no unknown part."""
    match type_:
        case Unknown():
            return False
        case ListOf(element) | RangeOf(element):
            return is_known(element)
        case _:
            return True
