"""Symbols, which are the meanings of names, and the types of values.

The passes of the checker fill symbols in turn: names, then bases and types. Symbols refer to the tree, which stays
unchanged. Types are compared by `==`; physical types have dimensions instead of names. `plan/types.py` has the
types of the runtime, and `check/plan_types.py` converts to them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from enum import Enum
from functools import cached_property
from typing import TypeAlias

from seoro.deferred import dataclass
from seoro.lang import ast, plan
from seoro.lang.frozen import Value
from seoro.lang.members import MemberTable
from seoro.lang.namespaces import GLOBAL_NAMESPACE, Home
from seoro.lang.source import Span
from seoro.lang.units import Dimension

PHASES: Mapping[str, plan.Phase] = {phase.value: phase for phase in plan.Phase}  # the predefined events (7.3.10.3)
MethodImplementation: TypeAlias = ast.ExpressionMethod | ast.UndefinedMethod | ast.ExternalMethod


@dataclass(eq=False)
class QuantitySymbol:
    """A physical type."""

    name: str
    namespace: str
    home: Home
    dimension: Dimension
    span: Span


@dataclass(eq=False)
class UnitSymbol:
    """A unit: `base value = value * factor + offset`."""

    name: str
    dimension: Dimension | None  # None after an error
    factor: float
    offset: float
    span: Span


@dataclass(eq=False)
class EnumSymbol:
    """An enumeration with the numbers of its members, in the order of declaration.

    `declared` has the members of the declaration and its extensions, in source order. `spaces` has the namespaces
    of the members.
    """

    name: str
    namespace: str
    home: Home
    span: Span
    declared: list[tuple[ast.EnumMemberDecl, Home]] = field(default_factory=list)
    members: dict[str, int] = field(default_factory=dict)
    spaces: dict[str, str] = field(default_factory=dict)
    plan_name: str = ""

    @cached_property
    def plan_type(self) -> plan.EnumType:
        """Its type in the plan, after its members are numbered."""
        return plan.EnumType(self.plan_name, tuple(self.members.items()))


class Primitive(Value):
    """A built-in type."""

    name: str


class Quantity(Value):
    """A physical type, or the type of a product or quotient of physical values.

    Types of one dimension are the same type, as the algebra of 7.3.4 requires.
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
    """An occurrence that `as <name>` binds; its fields are the parameters of the event."""

    symbol: EventSymbol


class CompositionObject(Value):
    """`it` in a composition; its fields are the parameters of the composition."""

    symbol: CompositionSymbol


class Unknown(Value):
    """The type of an invalid expression, which has been reported; compatible with all types."""


Type: TypeAlias = (
    Primitive | Quantity | Enumeration | Structured | ListOf | RangeOf | EventObject | CompositionObject | Unknown
)


@dataclass(eq=False)
class FieldSymbol:
    """A field of a structured type, a parameter of an event or a method, or a global parameter.

    `name` is unique in a type and its bases; `text` is the identifier, which fields of several namespaces may
    share.
    """

    name: str
    type: Type
    default: ast.Expression | None
    owner: TypeSymbol | None
    span: Span
    home: Home
    text: str
    namespace: str
    is_variable: bool = False


@dataclass(eq=False)
class EventSymbol:
    """An event of a structured type; `specification` follows `is`."""

    name: str
    owner: TypeSymbol
    span: Span
    home: Home
    specification: ast.EventSpecification | None = None
    text: str = ""
    namespace: str = GLOBAL_NAMESPACE
    parameters: MemberTable[FieldSymbol] = field(default_factory=MemberTable)


@dataclass(eq=False)
class MethodSymbol:
    """An implementation of a method; overriding methods share their `name`.

    `owner` is the declaring type, or None for a method of the primitive type `receiver`.
    """

    name: str
    text: str
    namespace: str
    owner: TypeSymbol | None
    receiver: Type
    parameters: MemberTable[FieldSymbol]
    result: Type | None
    implementation: MethodImplementation
    home: Home
    span: Span


@dataclass(eq=False)
class CompositionSymbol:
    """A composition operator or any behavior, with its possible parameters (7.3.13)."""

    name: str
    parameters: MemberTable[FieldSymbol]


class Kind(Enum):
    """Kind of a structured type."""

    STRUCT = "struct"
    ACTOR = "actor"
    SCENARIO = "scenario"
    ACTION = "action"
    MODIFIER = "modifier"


class Part(Value):
    """The declaration of a type, or an extension of it, with its members."""

    members: tuple[ast.TypeMember, ...]
    home: Home


class Condition(Value):
    """Condition of a conditional subtype (7.3.8.2): a field of the base has a value."""

    field: FieldSymbol
    value: ast.EnumValueReference | ast.BoolLiteral


@dataclass(eq=False)
class Inventory:
    """The members of a type, inherited ones first."""

    fields: MemberTable[FieldSymbol] = field(default_factory=MemberTable)
    events: MemberTable[EventSymbol] = field(default_factory=MemberTable)
    methods: MemberTable[MethodSymbol] = field(default_factory=MemberTable)

    def inherited(self) -> Inventory:
        """Return the initial inventory of a subtype."""
        return Inventory(MemberTable(self.fields), MemberTable(self.events), MemberTable(self.methods))


@dataclass(eq=False)
class TypeSymbol:
    """A struct, actor, scenario, action or modifier.

    `fields`, `events` and `methods` are its own members; `inventory` includes those of its bases. `do` is its own
    or inherited. An open type may have unknown members, as its base is unknown. Constraints may set fields of a
    constrained type. `of` is the scenario or action that a modifier modifies. `plan_name` is unique among types,
    among scenarios and actions, or among modifiers.
    """

    kind: Kind
    name: str
    namespace: str
    home: Home
    declaration: ast.StructuredTypeDeclaration
    span: Span  # of the name
    actor: TypeSymbol | None = None
    of: TypeSymbol | None = None
    base: TypeSymbol | None = None
    condition: Condition | None = None
    parts: list[Part] = field(default_factory=list)
    fields: dict[str, FieldSymbol] = field(default_factory=dict)
    events: dict[str, EventSymbol] = field(default_factory=dict)
    methods: dict[str, MethodSymbol] = field(default_factory=dict)
    inventory: Inventory = field(default_factory=Inventory)
    do: DoFound | None = None
    is_open: bool = False
    is_constrained: bool = False
    plan_name: str = ""

    def __post_init__(self) -> None:
        self.parts.append(Part(self.declaration.members, self.home))

    @property
    def qualified_name(self) -> str:
        """Name for people: `actor.name` for a member of an actor."""
        return f"{self.actor.name}.{self.name}" if self.actor is not None else self.name

    @property
    def name_in_plan(self) -> str:
        """Name in the plan that is unique among types of all kinds."""
        match self.kind:
            case Kind.STRUCT | Kind.ACTOR:
                return self.plan_name
            case Kind.SCENARIO | Kind.ACTION:
                return plan.behavior_type(self.plan_name)
            case Kind.MODIFIER:
                return plan.modifier_type(self.plan_name)

    @cached_property
    def plan_type(self) -> plan.StructType | plan.ActorType:
        """Its type in the plan, after all members are declared.

        Instances of scenarios and actions are like structs.
        """
        bases = tuple(base.name_in_plan for base in lineage(self) if base is not self)
        make = plan.ActorType if self.kind is Kind.ACTOR else plan.StructType
        return make(self.name_in_plan, bases, tuple(self.inventory.fields))


def lineage(symbol: TypeSymbol) -> Iterator[TypeSymbol]:
    """Yield a type and its bases, nearest first; resolved bases have no cycles."""
    current: TypeSymbol | None = symbol
    while current is not None:
        yield current
        current = current.base


def has_phases(symbol: TypeSymbol) -> bool:
    """Return whether a type has the predefined events: whether its values start and end."""
    return symbol.kind not in {Kind.STRUCT, Kind.ACTOR}


def is_open(symbol: TypeSymbol) -> bool:
    """Return whether a type or one of its bases may have unknown members."""
    return any(type_.is_open for type_ in lineage(symbol))


def may_lack_values(symbol: TypeSymbol) -> bool:
    """Return whether unknown members or constraints may set a field without a value."""
    return any(type_.is_open or type_.is_constrained for type_ in lineage(symbol))


class DoFound(Value):
    """The `do` of a scenario or action, with the declaring type and its scope."""

    owner: TypeSymbol
    directive: ast.DoDirective
    home: Home
