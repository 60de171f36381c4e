"""Structures of types: fields, and the constraints on their values (7.3.6, 7.3.11).

Members are in the order of application: those of bases, then those of the declaration and its extensions in source
order. Later constraints override a default constraint (7.3.11.3.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TypeAlias

from seoro.deferred import dataclass
from seoro.lang.frozen import Frozen, Value
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.types import ActorType, EnumValue, StructType, ValueType
from seoro.lang.source import Span


class FieldDeclaration(Value):
    """A field.

    Args:
        name: Its name, unique in the type.
        type: The type of its values.
        default: Its default value, in the scope of the instance, or None.
        is_variable: Whether it changes over time (7.3.6.1.2); variables are not constrained.
        span: Its name in the text.
    """

    name: str
    type: ValueType
    default: Expression | None
    is_variable: bool
    span: Span


class Constraint(Value):
    """`keep(<condition>)`, or the equivalent of an argument or a condition of inheritance.

    Args:
        condition: The condition, in the scope of the instance. In the `with:` block of a behavior, it is in the
            enclosing scope, and the binding `it` is the invoked instance or the composition.
        is_default: Whether later constraints override it (7.3.11.3.2).
        span: Its span.
    """

    condition: Expression
    is_default: bool
    span: Span


class RemoveDefault(Value):
    """`remove_default(<parameter>)`: removes preceding default constraints on the parameter."""

    parameter: Expression
    span: Span


ConstraintMember: TypeAlias = Constraint | RemoveDefault
StructureMember: TypeAlias = FieldDeclaration | Constraint | RemoveDefault


class Latent(Value):
    """A conditional subtype that an instance may have (7.3.8.2.5).

    Args:
        type: Its name.
        base: The name of its base.
        field: The deciding field.
        value: The required value of the field.
        members: Members that the subtype adds.
        span: Its name in the text.
    """

    type: str
    base: str
    field: str
    value: bool | EnumValue
    members: tuple[StructureMember, ...]
    span: Span


class Structure(Frozen):
    """Structure of a type's instances.

    Args:
        type: The type.
        fields: The fields among the members, by name.
        members: Fields and constraints, including those of bases.
        latents: The conditional subtypes that an instance may have, each after its base.
        open_fields: Names of the fields whose values are chosen unless they are given.
        span: Its name in the text.
        is_modified: Whether a struct or an actor has modifiers, which may constrain it.
    """

    type: StructType | ActorType
    fields: Mapping[str, FieldDeclaration]
    members: tuple[StructureMember, ...]
    latents: tuple[Latent, ...]
    open_fields: frozenset[str]
    span: Span
    is_modified: bool = False

    @property
    def is_plain(self) -> bool:
        """Whether only given values and defaults determine the fields."""
        return len(self.members) == len(self.fields) and not self.latents and not self.is_modified


@dataclass(eq=False)
class Structures:
    """The structures of all structs and actors, by the name of the type."""

    _found: dict[str, Structure] = field(default_factory=dict, repr=False)

    def add(self, structure: Structure) -> None:
        """Add a structure; for the checker."""
        self._found[structure.type.name] = structure

    def all(self) -> tuple[Structure, ...]:
        """Return all structures, in the order of addition."""
        return tuple(self._found.values())

    def find(self, type_: StructType | ActorType) -> Structure | None:
        """Return the structure of a type; None if it is not known yet."""
        return self._found.get(type_.name)

    def of(self, type_: StructType | ActorType) -> Structure:
        """Return the structure of a type."""
        return self._found[type_.name]
