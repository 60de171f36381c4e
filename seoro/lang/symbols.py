"""What names mean: the declarations of a program, collected and resolved by `check/`.

Symbols are filled by the passes of checking in turn (names, then bases and types), and not changed after it. They
live beside the tree and point into it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

from seoro.lang import ast
from seoro.lang.source import Span
from seoro.lang.types import Type
from seoro.lang.units import Dimension

GLOBAL_NAMESPACE = "null"


@dataclass(frozen=True)
class Home:
    """Where a declaration stands.

    Args:
        namespace: The namespace it is in.
        library: What was imported to get it, such as `osc.nav2`; None for files of the user.
    """

    namespace: str
    library: str | None


@dataclass(eq=False)
class QuantitySymbol:
    """A physical type."""

    name: str
    home: Home
    dimension: Dimension
    span: Span


@dataclass(eq=False)
class UnitSymbol:
    """A unit: `base value = value * factor + offset`."""

    name: str
    dimension: Dimension | None  # None if it was declared wrongly
    factor: float
    offset: float
    span: Span


@dataclass(eq=False)
class EnumSymbol:
    """An enumeration with the numbers of its members, in the order of declaration."""

    name: str
    home: Home
    declaration: ast.EnumDeclaration
    span: Span
    members: dict[str, int] = field(default_factory=dict)


@dataclass(eq=False)
class FieldSymbol:
    """A field of a structured type, or a parameter of an event."""

    name: str
    type: Type
    default: ast.Expression | None
    owner: TypeSymbol
    span: Span


@dataclass(eq=False)
class EventSymbol:
    """An event of a structured type."""

    name: str
    owner: TypeSymbol
    span: Span
    parameters: dict[str, FieldSymbol] = field(default_factory=dict)


class Kind(Enum):
    """What a structured type is."""

    STRUCT = "struct"
    ACTOR = "actor"
    SCENARIO = "scenario"
    ACTION = "action"
    MODIFIER = "modifier"


@dataclass(eq=False)
class TypeSymbol:
    """A struct, actor, scenario, action or modifier.

    `is_open` says that it may have members that are not known, as a part of it is not supported;
    `is_constrained`, that its fields may have values that are not known, for the same reason.
    """

    kind: Kind
    name: str
    home: Home
    declaration: ast.StructuredTypeDeclaration
    span: Span  # of the name
    actor: TypeSymbol | None = None
    base: TypeSymbol | None = None
    fields: dict[str, FieldSymbol] = field(default_factory=dict)
    events: dict[str, EventSymbol] = field(default_factory=dict)
    methods: dict[str, Span] = field(default_factory=dict)
    is_open: bool = False
    is_constrained: bool = False

    @property
    def qualified_name(self) -> str:
        """`actor.name` for what belongs to an actor, else the name."""
        return f"{self.actor.name}.{self.name}" if self.actor is not None else self.name


def lineage(symbol: TypeSymbol) -> Iterator[TypeSymbol]:
    """The type and its bases, nearest first; bases form no cycle once they are resolved."""
    current: TypeSymbol | None = symbol
    while current is not None:
        yield current
        current = current.base


def all_fields(symbol: TypeSymbol) -> dict[str, FieldSymbol]:
    """The fields of a type, inherited ones first."""
    found: dict[str, FieldSymbol] = {}
    for type_ in reversed(list(lineage(symbol))):
        found.update(type_.fields)
    return found


def all_events(symbol: TypeSymbol) -> dict[str, EventSymbol]:
    """The events of a type, inherited ones first."""
    found: dict[str, EventSymbol] = {}
    for type_ in reversed(list(lineage(symbol))):
        found.update(type_.events)
    return found


def is_open(symbol: TypeSymbol) -> bool:
    """Whether a type or one of its bases may have members that are not known."""
    return any(type_.is_open for type_ in lineage(symbol))


def may_lack_values(symbol: TypeSymbol) -> bool:
    """Whether a field without a value may get one from what is not supported."""
    return any(type_.is_open or type_.is_constrained for type_ in lineage(symbol))


def do_directive(symbol: TypeSymbol) -> tuple[TypeSymbol, ast.DoDirective] | None:
    """The `do` of a scenario or action, with the type that declares it: its own, or that of a base."""
    for type_ in lineage(symbol):
        for member in type_.declaration.members:
            if isinstance(member, ast.DoDirective):
                return type_, member
    return None


@dataclass
class Program:
    """All declarations.

    Args:
        uses: Namespaces whose names are accessible without prefix in the global one.
        is_lenient: Names may be missing because of what is not supported; they are not reported.
    """

    uses: frozenset[str]
    is_lenient: bool = False
    types: dict[tuple[str, str], QuantitySymbol | EnumSymbol | TypeSymbol] = field(default_factory=dict)
    behaviors: dict[tuple[str, TypeSymbol | None, str], TypeSymbol] = field(default_factory=dict)
    modifiers: dict[tuple[str, TypeSymbol | None, str], TypeSymbol] = field(default_factory=dict)
    units: dict[str, UnitSymbol] = field(default_factory=dict)
    globals: dict[str, Span] = field(default_factory=dict)
    holders: dict[str, list[EnumSymbol]] = field(
        default_factory=dict
    )  # enumerations by the names of their members

    def search(self, namespace: str, name: ast.Name) -> tuple[str, ...]:
        """The namespaces in which a name may be found, in order (7.7.4.2)."""
        if name.namespace is not None:
            return (name.namespace,)
        if namespace == GLOBAL_NAMESPACE:
            return (GLOBAL_NAMESPACE, *sorted(self.uses))
        return (namespace,)

    def find_type(self, namespace: str, name: ast.Name) -> QuantitySymbol | EnumSymbol | TypeSymbol | None:
        """The type that a name means."""
        for space in self.search(namespace, name):
            if (found := self.types.get((space, name.text))) is not None:
                return found
        return None

    def find_behavior(self, namespace: str, actor: TypeSymbol | None, name: ast.Name) -> TypeSymbol | None:
        """The scenario or action of an actor, or of none, that a name means; an actor has those of its bases."""
        return self._find(self.behaviors, namespace, actor, name)

    def find_modifier(self, namespace: str, actor: TypeSymbol | None, name: ast.Name) -> TypeSymbol | None:
        """The modifier that a name means."""
        return self._find(self.modifiers, namespace, actor, name)

    def _find(
        self,
        table: dict[tuple[str, TypeSymbol | None, str], TypeSymbol],
        namespace: str,
        actor: TypeSymbol | None,
        name: ast.Name,
    ) -> TypeSymbol | None:
        owners: list[TypeSymbol | None] = list(lineage(actor)) if actor is not None else [None]
        for owner in owners:
            for space in self.search(namespace, name):
                if (found := table.get((space, owner, name.text))) is not None:
                    return found
        return None

    @cached_property
    def quantities(self) -> dict[Dimension, str]:
        """The name of the first physical type of each dimension; for use when all types are declared."""
        names: dict[Dimension, str] = {}
        for symbol in self.types.values():
            if isinstance(symbol, QuantitySymbol):
                names.setdefault(symbol.dimension, symbol.name)
        return names
