"""Types as checking sees them: structural, compared by `==`, with dimensions instead of names for physical ones.

`plan.py` has the types that the runtime sees; `lower/plan_types.py` translates.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.units import DIMENSIONLESS, Dimension

if TYPE_CHECKING:
    from seoro.lang.symbols import CompositionSymbol, EnumSymbol, EventSymbol, TypeSymbol


class Primitive(Value):
    """A built-in type."""

    name: str


class Quantity(Value):
    """A physical type, or the type of a product or quotient of physical values.

    Types of one dimension are the same type, as the algebra of 7.3.4 asks for.
    """

    dimension: Dimension


class Enumeration(Value):
    """An enumeration."""

    symbol: EnumSymbol


class Structured(Value):
    """A struct or an actor."""

    symbol: TypeSymbol


class ListOf(Value):
    """`list of <element>`."""

    element: Type


class RangeOf(Value):
    """`range of <element>`."""

    element: Type


class EventObject(Value):
    """What `as <name>` binds: an occurrence, with the event's parameters as its fields."""

    symbol: EventSymbol


class CompositionObject(Value):
    """What `it` is for a composition: the parameters of the composition are its fields."""

    symbol: CompositionSymbol


class Unknown(Value):
    """The type of what is wrong, and has been reported: it goes with everything."""


Type: TypeAlias = (
    Primitive | Quantity | Enumeration | Structured | ListOf | RangeOf | EventObject | CompositionObject | Unknown
)

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
    """Whether it is `int` or `uint`."""
    return isinstance(type_, Primitive) and type_.name in _INTEGERS


def is_plain_number(type_: Type) -> bool:
    """Whether it is a number without a dimension."""
    return isinstance(type_, Primitive) and type_.name in _PLAIN_NUMBERS


def is_number(type_: Type) -> bool:
    """Whether it is a number, with or without a dimension."""
    return is_plain_number(type_) or isinstance(type_, Quantity)


def quantity(dimension: Dimension) -> Type:
    """The type of values of a dimension; those without one are `float`."""
    return FLOAT if dimension == DIMENSIONLESS else Quantity(dimension)


def dimension_of(type_: Type) -> Dimension:
    """The dimension of a numeric type."""
    return type_.dimension if isinstance(type_, Quantity) else DIMENSIONLESS


def is_known(type_: Type) -> bool:
    """Whether nothing in it is unknown."""
    match type_:
        case Unknown():
            return False
        case ListOf(element) | RangeOf(element):
            return is_known(element)
        case _:
            return True
