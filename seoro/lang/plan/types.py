"""Types of the plan, and values of enumerations."""

from __future__ import annotations

from typing import TypeAlias

from seoro.lang.frozen import Value


class PrimitiveType(Value):
    """`bool`, `int`, `uint`, `float` or `string`."""

    name: str


class PhysicalType(Value):
    """A physical type.

    Args:
        name: Its name.
        unit: Its SI base unit as text, such as `m/s`, for people to read.
        literal: The unit of the language that is this base unit, such as `mps`; empty if none is declared.
    """

    name: str
    unit: str
    literal: str = ""


class EnumType(Value):
    """An enumeration with its members in the order of declaration."""

    name: str
    members: tuple[tuple[str, int], ...]


class StructType(Value):
    """A struct; its fields in the order of declaration, inherited ones first."""

    name: str
    bases: tuple[str, ...]  # nearest first
    fields: tuple[str, ...]


class ActorType(Value):
    """An actor; `bases` are the names of the types it inherits, nearest first."""

    name: str
    bases: tuple[str, ...]
    fields: tuple[str, ...]


class ListType(Value):
    """`list of <element>`."""

    element: ValueType


class RangeType(Value):
    """`range of <element>`; the element is numeric."""

    element: ValueType


ValueType: TypeAlias = PrimitiveType | PhysicalType | EnumType | StructType | ActorType | ListType | RangeType


class EnumValue(Value):
    """A member of an enumeration; members with one number are the same value (7.3.3)."""

    type_name: str
    member: str
    number: int

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, EnumValue):
            return NotImplemented
        return (self.type_name, self.number) == (other.type_name, other.number)

    def __hash__(self) -> int:
        return hash((self.type_name, self.number))
