"""What instances of types are made of: fields, and the constraints on their values (7.3.6, 7.3.11).

Members stand in the order in which they are applied: those of bases, then those of the declaration and of its
extensions in the order of the text. A default constraint is overridden by what comes after it (7.3.11.3.2).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from seoro.lang.frozen import Frozen, Value
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.types import ActorType, EnumValue, StructType, ValueType
from seoro.lang.source import Span

if TYPE_CHECKING:
    from seoro.lang.plan.declarations import Modifier
    from seoro.lang.plan.modifications import AppliedModifier


class FieldDeclaration(Value):
    """A field.

    Args:
        name: Its name, unique in the type.
        type: The type of its values.
        default: Its default value, in the scope of the instance; None if it has none.
        is_variable: Whether it changes over time (7.3.6.1.2); variables are not constrained.
        span: Its name in the text.
    """

    name: str
    type: ValueType
    default: Expression | None
    is_variable: bool
    span: Span


class Constraint(Value):
    """`keep(<condition>)`, or what an argument or a condition of inheritance stands for.

    Args:
        condition: What has to be true, in the scope of the instance; in the `with` block of a behavior, in the
            scope around it, with the binding `it` for the instance that is invoked, or for the composition.
        is_default: Whether later constraints override it (7.3.11.3.2).
        span: Its place in the text.
    """

    condition: Expression
    is_default: bool
    span: Span


class RemoveDefault(Value):
    """`remove_default(<parameter>)`: default constraints before it that concern the parameter are void."""

    parameter: Expression
    span: Span


ConstraintMember: TypeAlias = Constraint | RemoveDefault
StructureMember: TypeAlias = FieldDeclaration | Constraint | RemoveDefault


class Latent(Value):
    """A conditional subtype that an instance may turn out to be of (7.3.8.2.5).

    Args:
        type: Its name.
        base: The name of what it inherits.
        field: The field that decides.
        value: What it has to be.
        members: What the subtype adds.
        span: Its name in the text.
    """

    type: str
    base: str
    field: str
    value: bool | EnumValue
    members: tuple[StructureMember, ...]
    span: Span


class Structure(Frozen):
    """What instances of a type are made of.

    Args:
        type: The type.
        fields: The fields among the members, by name.
        members: Fields and constraints, those of bases included.
        latents: The conditional subtypes that an instance may be of, each after its base.
        open_fields: Names of the fields whose values have to be chosen if they are not given.
        span: Its name in the text.
        is_modified: Whether modifiers are members of a struct or an actor, which may constrain it.
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
        """Whether nothing but given values and defaults decides about the fields."""
        return len(self.members) == len(self.fields) and not self.latents and not self.is_modified


@dataclass(eq=False, slots=True)
class Structures:
    """The structures of all structs and actors, by the name of the type, and the modifiers that are their members.

    Expressions refer to it instead of holding what they construct, since types contain each other.

    Args:
        modifiers: All modifiers that are applied, by their names.
    """

    modifiers: Mapping[str, Modifier] = field(default_factory=dict, repr=False)
    _found: dict[str, Structure] = field(default_factory=dict, repr=False)
    _applied: Mapping[str, tuple[AppliedModifier, ...]] = field(default_factory=dict, repr=False)

    def add(self, structure: Structure) -> None:
        """Add a structure; for checking."""
        self._found[structure.type.name] = structure

    def modify(
        self, modifiers: Mapping[str, Modifier], applied: Mapping[str, tuple[AppliedModifier, ...]]
    ) -> None:
        """Say which modifiers there are, and which are members of which types; for lowering."""
        self.modifiers, self._applied = modifiers, applied

    def applied_to(self, types: Iterable[str]) -> tuple[AppliedModifier, ...]:
        """The modifiers of a value whose types these are, nearest first; the nearest has those of all."""
        return next((self._applied[name] for name in types if name in self._applied), ())

    def all(self) -> tuple[Structure, ...]:
        """All structures, in the order in which they were added."""
        return tuple(self._found.values())

    def find(self, type_: StructType | ActorType) -> Structure | None:
        """The structure of a type; None before it is known."""
        return self._found.get(type_.name)

    def of(self, type_: StructType | ActorType) -> Structure:
        """The structure of a type."""
        return self._found[type_.name]
