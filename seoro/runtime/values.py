"""Values of scenarios at run time: instances of structs and actors, ranges, 64-bit integers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeAlias, TypeVar

from seoro.lang import frozen
from seoro.lang.integers import INT_LIMITS, UINT_LIMITS
from seoro.lang.plan import ActorType, EnumValue, StructType, ValueType

if TYPE_CHECKING:
    from seoro.runtime.applied import Applied

Value: TypeAlias = (
    "bool | int | float | str | EnumValue | Struct | Actor | Range | Variable[Any] | tuple[Value, ...]"
)
Held = TypeVar("Held")

INTEGER_LIMITS = {"int": INT_LIMITS, "uint": UINT_LIMITS}


@dataclass(eq=False)
class Struct:
    """An instance of a struct; equal to nothing but itself (7.4.2.4.2).

    Args:
        type: Its declared type.
        fields: Its fields by name.
        latent: Names of the conditional subtypes that it is of, nearest first (7.3.8.2.5).
        modifiers: The modifiers that are members of its types, as they are applied to it.
    """

    type: StructType
    fields: dict[str, Value] = field(default_factory=dict)
    latent: list[str] = field(default_factory=list)
    modifiers: tuple[Applied, ...] = ()

    @property
    def types(self) -> tuple[str, ...]:
        """Names of its types and of what they inherit, nearest first."""
        return (*self.latent, self.type.name, *self.type.bases)


@dataclass(eq=False)
class Actor:
    """An instance of an actor.

    Args:
        type: Its type.
        name: Path of the field that holds it, such as `robot`.
        fields: Its fields by name.
        latent: Names of the conditional subtypes that it is of, nearest first (7.3.8.2.5).
        modifiers: The modifiers that are members of its types, as they are applied to it.
    """

    type: ActorType
    name: str
    fields: dict[str, Value] = field(default_factory=dict)
    latent: list[str] = field(default_factory=list)
    modifiers: tuple[Applied, ...] = ()

    @property
    def types(self) -> tuple[str, ...]:
        """Names of its types and of what they inherit, nearest first."""
        return (*self.latent, self.type.name, *self.type.bases)


class HasFields(Protocol):
    """Anything with fields by name: structs, actors, instances of scenarios, event objects."""

    @property
    def fields(self) -> Mapping[str, Value]:
        """Values by name."""
        ...


class Invoker(HasFields, Protocol):
    """An instance of a scenario or an action."""

    def invoked(self, label: str) -> Invoker | None:
        """What it has invoked last under a label; None before the first time."""
        ...


@dataclass(frozen=True, eq=False)
class Variable(Generic[Held]):
    """A variable itself, which an action can change; of the value that it holds, the annotation tells the type.

    Args:
        holder: What has it as a field.
        name: The name of the field.
        type: What it holds.
        path: What people call it.
    """

    holder: HasFields
    name: str
    type: ValueType
    path: str

    @property
    def value(self) -> Held:
        """What it holds now."""
        return self.holder.fields[self.name]  # type: ignore[return-value] # checked with the argument


class Range(frozen.Value):
    """All values from low to high, both included."""

    low: float
    high: float

    def __contains__(self, value: object) -> bool:
        return isinstance(value, int | float) and self.low <= value <= self.high


def plain(value: Value) -> object:
    """The value as JSON knows it, for traces and results."""
    match value:
        case EnumValue():
            return f"{value.type_name}!{value.member}"
        case Struct():
            return {name: plain(part) for name, part in value.fields.items()}
        case Actor():
            return value.name
        case Variable():
            return value.path
        case Range():
            return {"low": value.low, "high": value.high}
        case tuple():
            return [plain(item) for item in value]
        case _:
            return value
