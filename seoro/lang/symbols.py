"""What names mean: the declarations of a program, collected and resolved by `check/`.

Symbols are filled by the passes of checking in turn (names, then bases and types), and not changed after it. They
live beside the tree and point into it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import TypeAlias

from seoro.lang import ast, plan
from seoro.lang.frozen import Value
from seoro.lang.members import MemberTable
from seoro.lang.recorder import Recorder
from seoro.lang.source import Span
from seoro.lang.types import Type
from seoro.lang.units import Dimension

GLOBAL_NAMESPACE = "null"
PHASES: Mapping[str, plan.Phase] = {phase.value: phase for phase in plan.Phase}  # the predefined events (7.3.10.3)
MethodImplementation: TypeAlias = ast.ExpressionMethod | ast.UndefinedMethod | ast.ExternalMethod


class Space(Value):
    """The scope of a namespace statement: where names without a prefix are looked for (7.7.4.2)."""

    name: str
    uses: frozenset[str] = frozenset()


class Home(Value):
    """Where a declaration stands.

    Args:
        space: The scope of the text.
        library: What was imported to get it, such as `osc.nav2`; None for files of the user.
    """

    space: Space
    library: str | None

    def namespace_of(self, name: ast.Name) -> str:
        """The namespace into which a name is defined here: the current one, unless it has a prefix."""
        return name.namespace or self.space.name


class Export(Value):
    """An item of an export list: a name, or all names of a namespace (7.7.4.1)."""

    namespace: str | None  # None if the name has no prefix
    name: str | None  # None for all names
    home: Home
    span: Span


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
    dimension: Dimension | None  # None if it was declared wrongly
    factor: float
    offset: float
    span: Span


@dataclass(eq=False)
class EnumSymbol:
    """An enumeration with the numbers of its members, in the order of declaration.

    `declared` has the members of the declaration and then those of its extensions, in the order of the text;
    `spaces`, the namespaces in which the names of members are.
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
        """What it is in the plan; for use when its members are numbered."""
        return plan.EnumType(self.plan_name, tuple(self.members.items()))


@dataclass(eq=False)
class FieldSymbol:
    """A field of a structured type, a parameter of an event or a method, or a global parameter.

    `name` is unique among the fields of a type and of all that it inherits; `text` is the identifier, which fields
    of several namespaces may share.
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
    """An event of a structured type; `specification` is what stands behind `is`."""

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
    """An implementation of a method; those that override one another share their `name`.

    `owner` is None for a method of a primitive type, which `receiver` names; else it is the type that has it.
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
    """A composition operator with its parameters (7.3.13); or any behavior, with those that one may have."""

    name: str
    parameters: MemberTable[FieldSymbol]


class Kind(Enum):
    """What a structured type is."""

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
    """What makes a value of the base one of a conditional subtype (7.3.8.2): a field has a value."""

    field: FieldSymbol
    value: ast.EnumValueReference | ast.BoolLiteral


@dataclass(eq=False)
class Inventory:
    """The members of a type, inherited ones first."""

    fields: MemberTable[FieldSymbol] = field(default_factory=MemberTable)
    events: MemberTable[EventSymbol] = field(default_factory=MemberTable)
    methods: MemberTable[MethodSymbol] = field(default_factory=MemberTable)

    def inherited(self) -> Inventory:
        """What a subtype begins with."""
        return Inventory(MemberTable(self.fields), MemberTable(self.events), MemberTable(self.methods))


@dataclass(eq=False)
class TypeSymbol:
    """A struct, actor, scenario, action or modifier.

    `fields`, `events` and `methods` are its own, `inventory` has those of its bases too; `do` is its own or one of
    a base. `is_open` says that it may have members that are not known, as its base is not; `is_constrained`, that
    constraints may give its fields values. `of` is the scenario or action that a modifier is for. `plan_name` is
    unique among types, among scenarios and actions, or among modifiers.
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
        """`actor.name` for what belongs to an actor, else the name; for people."""
        return f"{self.actor.name}.{self.name}" if self.actor is not None else self.name

    @property
    def name_in_plan(self) -> str:
        """What the plan calls it where types of all kinds have names."""
        match self.kind:
            case Kind.STRUCT | Kind.ACTOR:
                return self.plan_name
            case Kind.SCENARIO | Kind.ACTION:
                return plan.behavior_type(self.plan_name)
            case Kind.MODIFIER:
                return plan.modifier_type(self.plan_name)

    @cached_property
    def plan_type(self) -> plan.StructType | plan.ActorType:
        """What it is in the plan; for use when all members are declared.

        An instance of a scenario or an action is held like a struct.
        """
        bases = tuple(base.name_in_plan for base in lineage(self) if base is not self)
        make = plan.ActorType if self.kind is Kind.ACTOR else plan.StructType
        return make(self.name_in_plan, bases, tuple(self.inventory.fields))


def lineage(symbol: TypeSymbol) -> Iterator[TypeSymbol]:
    """The type and its bases, nearest first; bases form no cycle once they are resolved."""
    current: TypeSymbol | None = symbol
    while current is not None:
        yield current
        current = current.base


def all_fields(symbol: TypeSymbol) -> MemberTable[FieldSymbol]:
    """The fields of a type, inherited ones first."""
    return symbol.inventory.fields


def all_events(symbol: TypeSymbol) -> MemberTable[EventSymbol]:
    """The events of a type, inherited ones first."""
    return symbol.inventory.events


def all_methods(symbol: TypeSymbol) -> MemberTable[MethodSymbol]:
    """The methods of a type with the implementations that it has, inherited ones first."""
    return symbol.inventory.methods


def has_phases(symbol: TypeSymbol) -> bool:
    """Whether the predefined events are events of a type: whether its values have a beginning and an end."""
    return symbol.kind not in {Kind.STRUCT, Kind.ACTOR}


def is_open(symbol: TypeSymbol) -> bool:
    """Whether a type or one of its bases may have members that are not known."""
    return any(type_.is_open for type_ in lineage(symbol))


def may_lack_values(symbol: TypeSymbol) -> bool:
    """Whether a field without a value may get one from what is not supported."""
    return any(type_.is_open or type_.is_constrained for type_ in lineage(symbol))


class DoFound(Value):
    """The `do` of a scenario or action: which type declares it, and in what scope."""

    owner: TypeSymbol
    directive: ast.DoDirective
    home: Home


def do_directive(symbol: TypeSymbol) -> DoFound | None:
    """The `do` of a scenario or action: its own, one of its extensions, or that of a base."""
    return symbol.do


Declaration: TypeAlias = QuantitySymbol | EnumSymbol | TypeSymbol
TypeTable: TypeAlias = dict[tuple[str, TypeSymbol | None, str], TypeSymbol]


@dataclass
class Program:
    """All declarations; tables are by namespace and name. `check/lookup.py` finds what a name means.

    Args:
        nowhere: The beginning of the entry file, for what has no place of its own.
        unread: Names that text which could not be read may declare; None for any name.
        recorder: Is told what names mean; None unless an editor asks.
    """

    nowhere: Span
    unread: frozenset[str] | None = frozenset()
    recorder: Recorder | None = None
    types: dict[tuple[str, str], Declaration] = field(default_factory=dict)
    behaviors: TypeTable = field(default_factory=dict)
    modifiers: TypeTable = field(default_factory=dict)
    units: dict[str, UnitSymbol] = field(default_factory=dict)
    globals: dict[tuple[str, str], FieldSymbol] = field(default_factory=dict)
    primitives: dict[str, MemberTable[MethodSymbol]] = field(default_factory=dict)  # methods by primitive type
    conditionals: list[TypeSymbol] = field(default_factory=list)  # conditional subtypes, bases first
    holders: dict[str, list[EnumSymbol]] = field(
        default_factory=dict
    )  # enumerations by the names of their members
    defined: set[tuple[str, str]] = field(default_factory=set)  # all identifiers, with their namespaces
    exports: dict[str, dict[str | None, list[Export]]] = field(default_factory=dict)  # by namespace and name
    methods: plan.Methods = field(default_factory=plan.Methods)
    structures: plan.Structures = field(default_factory=plan.Structures)
    global_declarations: list[tuple[ast.ParameterDeclaration, Home]] = field(default_factory=list)

    def is_unread(self, name: str) -> bool:
        """Whether text that could not be read may declare a name; it is then not reported as unknown."""
        return self.unread is None or name in self.unread

    def structured(self) -> list[TypeSymbol]:
        """All structs, actors, scenarios, actions and modifiers."""
        types = [symbol for symbol in self.types.values() if isinstance(symbol, TypeSymbol)]
        return [*types, *self.behaviors.values(), *self.modifiers.values()]

    @cached_property
    def globals_by_name(self) -> dict[str, FieldSymbol]:
        """Global parameters by their unique names; for use when all are declared."""
        return {parameter.name: parameter for parameter in self.globals.values()}

    @cached_property
    def quantities(self) -> dict[Dimension, str]:
        """The name of the first physical type of each dimension; for use when all types are declared."""
        names: dict[Dimension, str] = {}
        for symbol in self.types.values():
            if isinstance(symbol, QuantitySymbol):
                names.setdefault(symbol.dimension, symbol.name)
        return names
