"""What interfaces are made of: structures with fields and constants.

Services and actions are no kinds of their own here: what goes over the wire are structures, whose names follow
from those of the service or the action (`derived.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, TypeAlias

# Whole numbers with their least and greatest values. `char` and `byte` are numbers from 0 to 255 in ROS 2.
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
    """A primitive: a number, a truth value or a text of at most `bound` bytes (0: of any length)."""

    name: str
    bound: int = 0

    def __str__(self) -> str:
        return f"{self.name}<={self.bound}" if self.bound else self.name


@dataclass(frozen=True)
class Named:
    """Another structure, by its full name."""

    name: str

    def __str__(self) -> str:
        return self.name


Element: TypeAlias = Scalar | Named


@dataclass(frozen=True)
class Array:
    """Exactly `length` elements."""

    element: Element
    length: int

    def __str__(self) -> str:
        return f"{self.element}[{self.length}]"


@dataclass(frozen=True)
class Sequence:
    """Any number of elements, or at most `bound` if that is not 0."""

    element: Element
    bound: int = 0

    def __str__(self) -> str:
        return f"{self.element}[{f'<={self.bound}' if self.bound else ''}]"


FieldType: TypeAlias = Scalar | Named | Array | Sequence


@dataclass(frozen=True)
class Field:
    """A member of a structure.

    Args:
        name: As in the definition.
        type: Its type.
        default: What it has if nobody says; None where the definition gives no default, which means zero or empty.
        line: Where the definition has it, from 1; 0 for what follows from a rule.
    """

    name: str
    type: FieldType
    default: Literal | tuple[Literal, ...] | None = None
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Constant:
    """A name for a value, which is on no wire."""

    name: str
    type: Scalar
    value: Literal


@dataclass(frozen=True)
class Structure:
    """What a message consists of.

    Args:
        name: The full name, such as `geometry_msgs/msg/Point` or `std_srvs/srv/SetBool_Request`.
        fields: In the order of the wire.
        constants: In the order of the definition.
        origin: The file that defines it, for messages.
    """

    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = ()
    origin: str = field(default="", compare=False)


# A structure without members has this one on the wire and in its hash, since IDL knows no empty structures.
_FILLER: Final = (Field("structure_needs_at_least_one_member", Scalar("uint8")),)


def wire_fields(structure: Structure) -> tuple[Field, ...]:
    """The fields of a structure as they are on the wire."""
    return structure.fields or _FILLER


def element_of(type_: FieldType) -> Element:
    """What a type has one or many of."""
    return type_.element if isinstance(type_, Array | Sequence) else type_
