"""Definitions of interfaces: structures with fields and constants.

Services and actions have no classes here: they consist of structures, whose names derive from that of the service
or action (`derived.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, TypeAlias

# Integer types with their minimum and maximum. `char` and `byte` are numbers from 0 to 255 in ROS 2.
INTEGERS: Final = {
    "byte": (0, 255),
    "char": (0, 255),
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}
FLOATS: Final = ("float32", "float64")
TEXTS: Final = ("string", "wstring")
PRIMITIVES: Final = frozenset(("bool", *INTEGERS, *FLOATS, *TEXTS))

Literal: TypeAlias = bool | int | float | str


@dataclass(frozen=True)
class Scalar:
    """A primitive type: a number, a boolean, or a string of at most `bound` bytes (0 for no limit)."""

    name: str
    bound: int = 0

    def __str__(self) -> str:
        return f"{self.name}<={self.bound}" if self.bound else self.name


@dataclass(frozen=True)
class Named:
    """Reference to another structure by its full name."""

    name: str

    def __str__(self) -> str:
        return self.name


Element: TypeAlias = Scalar | Named


@dataclass(frozen=True)
class Array:
    """Array of exactly `length` elements."""

    element: Element
    length: int

    def __str__(self) -> str:
        return f"{self.element}[{self.length}]"


@dataclass(frozen=True)
class Sequence:
    """Sequence of at most `bound` elements (0 for no limit)."""

    element: Element
    bound: int = 0

    def __str__(self) -> str:
        return f"{self.element}[{f'<={self.bound}' if self.bound else ''}]"


FieldType: TypeAlias = Scalar | Named | Array | Sequence


@dataclass(frozen=True)
class Field:
    """A member of a structure.

    Args:
        name: Name in the definition.
        type: Type of the member.
        default: Default in the definition; None for zero or empty.
        line: Line of the definition, from 1; 0 for derived fields.
    """

    name: str
    type: FieldType
    default: Literal | tuple[Literal, ...] | None = None
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Constant:
    """A constant, which is not part of messages."""

    name: str
    type: Scalar
    value: Literal


@dataclass(frozen=True)
class Structure:
    """Structure of a message.

    Args:
        name: Full name, such as `geometry_msgs/msg/Point` or `std_srvs/srv/SetBool_Request`.
        fields: Fields in the order of the wire.
        constants: Constants in the order of the definition.
        origin: File of the definition, in error messages.
    """

    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = ()
    origin: str = field(default="", compare=False)


# Member of empty structures on the wire and in type hashes, since IDL does not allow empty structures.
FILLER: Final = (Field("structure_needs_at_least_one_member", Scalar("uint8")),)


def wire_fields(structure: Structure) -> tuple[Field, ...]:
    """Return the fields of a structure on the wire."""
    return structure.fields or FILLER


def element_of(type_: FieldType) -> Element:
    """Return the element type of an array or a sequence."""
    return type_.element if isinstance(type_, Array | Sequence) else type_
