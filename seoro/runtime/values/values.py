"""Values of scenarios at run time: instances of structs and actors, ranges, 64-bit integers.

While the values of an instance are chosen, its missing fields are computed on access.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from seoro.deferred import dataclass
from seoro.lang import frozen
from seoro.lang.arithmetic import INT_LIMITS, UINT_LIMITS
from seoro.lang.plan import ActorType, EnumValue, ModifierApplication, StructType, ValueType

Value: TypeAlias = (
    "bool | int | float | str | EnumValue | Struct | Actor | Range | Variable[Any] | tuple[Value, ...]"
)
Held = TypeVar("Held")

INTEGER_LIMITS = {"int": INT_LIMITS, "uint": UINT_LIMITS}


class AppliedModifier(Protocol):
    """A modifier applied to a value; see `instances.applied`."""

    @property
    def plan(self) -> ModifierApplication:
        """Its application in the plan."""


@dataclass(eq=False)
class Struct:
    """An instance of a struct; equal only to itself (7.4.2.4.2).

    Args:
        type: Its declared type.
        fields: Fields by name.
        latent: Names of its conditional subtypes, nearest first (7.3.8.2.5).
        modifiers: Applied modifiers that are members of its types.
    """

    type: StructType
    fields: dict[str, Value] = field(default_factory=dict)
    latent: list[str] = field(default_factory=list)
    modifiers: tuple[AppliedModifier, ...] = ()

    @property
    def types(self) -> tuple[str, ...]:
        """Names of its types, including inherited ones, nearest first."""
        return (*self.latent, self.type.name, *self.type.bases)


@dataclass(eq=False)
class Actor:
    """An instance of an actor.

    Args:
        type: Its type.
        name: Path of the field that holds it, such as `robot`.
        fields: Fields by name.
        latent: Names of its conditional subtypes, nearest first (7.3.8.2.5).
        modifiers: Applied modifiers that are members of its types.
    """

    type: ActorType
    name: str
    fields: dict[str, Value] = field(default_factory=dict)
    latent: list[str] = field(default_factory=list)
    modifiers: tuple[AppliedModifier, ...] = ()

    @property
    def types(self) -> tuple[str, ...]:
        """Names of its types, including inherited ones, nearest first."""
        return (*self.latent, self.type.name, *self.type.bases)


class HasFields(Protocol):
    """An object with fields: a struct, an actor, an instance of a scenario, or an event object."""

    @property
    def fields(self) -> Mapping[str, Value]:
        """Values by name."""


class Invoker(HasFields, Protocol):
    """An instance of a scenario or an action."""

    def invoked(self, label: str) -> Invoker | None:
        """Return the last invocation under a label; None before the first one."""


@dataclass(frozen=True, eq=False)
class Variable(Generic[Held]):
    """Reference to a variable, which an action can change; the annotation gives the type of its value.

    Args:
        holder: Object with the variable as a field.
        name: Name of the field.
        type: Type of its values.
        path: Name in messages.
    """

    holder: HasFields
    name: str
    type: ValueType
    path: str

    @property
    def value(self) -> Held:
        """Current value."""
        return self.holder.fields[self.name]  # type: ignore[return-value] # checked with the argument


class Range(frozen.Value):
    """Closed range of values."""

    low: float
    high: float

    def __contains__(self, value: object) -> bool:
        return isinstance(value, int | float) and self.low <= value <= self.high


def plain(value: Value) -> object:
    """Convert a value for JSON, for traces and results."""
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


Compute = Callable[[str], Value]

_FRAMES = 12  # of Python's stack per value that refers to another one
_MAX_ROW = 4000  # longest chain of values that refer to each other


class Fields(dict[str, Value]):
    """Values by name.

    `compute` returns a missing value, or raises `KeyError`; None when all values are set.
    """

    compute: Compute | None = None

    def __missing__(self, name: str) -> Value:
        if self.compute is None:
            raise KeyError(name)
        return self.compute(name)


def make_room(count: int) -> None:
    """Raise Python's recursion limit for a chain of values that refer to each other.

    The limit belongs to the process. It is never lowered, since another thread may need it.

    Args:
        count: Number of values.
    """
    needed = 1000 + _FRAMES * min(count, _MAX_ROW)
    if count > _FRAMES and needed > sys.getrecursionlimit():
        sys.setrecursionlimit(needed)
