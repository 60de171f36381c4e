"""The declarations of a program, collected and resolved by `check/`, and recorders of a check for editors."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import Protocol, TypeAlias

from seoro.deferred import dataclass
from seoro.lang import ast, plan, symbols
from seoro.lang.frozen import Value
from seoro.lang.members import MemberTable
from seoro.lang.namespaces import Export, Home
from seoro.lang.source import Span
from seoro.lang.units import Dimension


class EnumMember(Value):
    """A member of an enumeration as the meaning of a name; all other names denote symbols."""

    enum: symbols.EnumSymbol
    text: str


class Recorder(Protocol):
    """Receiver of names and values during a check."""

    def name(self, span: Span, meaning: object) -> None:
        """Record the meaning of a name; later calls for the same span replace earlier ones."""

    def value(self, span: Span, type_: symbols.Type) -> None:
        """Record the type of an expression."""


Declaration: TypeAlias = symbols.QuantitySymbol | symbols.EnumSymbol | symbols.TypeSymbol
TypeTable: TypeAlias = dict[tuple[str, symbols.TypeSymbol | None, str], symbols.TypeSymbol]


def actors_with(table: TypeTable, name: str) -> list[str]:
    """Return the names of the actors that have a behavior or a modifier of a name."""
    return [actor.name for _, actor, found in table if actor is not None and found == name]


@dataclass(eq=False)
class Program:
    """All declarations; tables are by namespace and name. `check/lookup.py` resolves names.

    Args:
        nowhere: Start of the entry file, as the span of implicit declarations.
        unread: Names that unreadable text may declare; None for any name.
        recorder: Receives the meanings of names, for editors.
    """

    nowhere: Span
    unread: frozenset[str] | None = frozenset()
    recorder: Recorder | None = None
    types: dict[tuple[str, str], Declaration] = field(default_factory=dict)
    behaviors: TypeTable = field(default_factory=dict)
    modifiers: TypeTable = field(default_factory=dict)
    units: dict[str, symbols.UnitSymbol] = field(default_factory=dict)
    globals: dict[tuple[str, str], symbols.FieldSymbol] = field(default_factory=dict)
    primitives: dict[str, MemberTable[symbols.MethodSymbol]] = field(
        default_factory=dict
    )  # methods by primitive type
    conditionals: list[symbols.TypeSymbol] = field(default_factory=list)  # conditional subtypes, bases first
    enumerations_by_member: dict[str, list[symbols.EnumSymbol]] = field(default_factory=dict)
    defined: set[tuple[str, str]] = field(default_factory=set)  # all identifiers, with their namespaces
    exports: dict[str, dict[str | None, list[Export]]] = field(default_factory=dict)  # by namespace and name
    methods: plan.Methods = field(default_factory=plan.Methods)
    structures: plan.Structures = field(default_factory=plan.Structures)
    global_declarations: list[tuple[ast.ParameterDeclaration, Home]] = field(default_factory=list)

    def is_unread(self, name: str) -> bool:
        """Return whether unreadable text may declare a name, which is then not reported as unknown."""
        return self.unread is None or name in self.unread

    def structured(self) -> list[symbols.TypeSymbol]:
        """Return all structs, actors, scenarios, actions and modifiers."""
        types = [symbol for symbol in self.types.values() if isinstance(symbol, symbols.TypeSymbol)]
        return [*types, *self.behaviors.values(), *self.modifiers.values()]

    def types_of(self, kind: symbols.Kind | type[Declaration]) -> tuple[str, ...]:
        """Return the names of all types of a kind, as suggestions for unknown names."""
        return tuple(
            symbol.name
            for symbol in self.types.values()
            if (symbol.kind is kind if isinstance(symbol, symbols.TypeSymbol) else type(symbol) is kind)
        )

    @cached_property
    def globals_by_name(self) -> dict[str, symbols.FieldSymbol]:
        """Global parameters by unique name, after all are declared."""
        return {parameter.name: parameter for parameter in self.globals.values()}

    @cached_property
    def quantities(self) -> dict[Dimension, str]:
        """The name of the first physical type of each dimension, after all types are declared."""
        names: dict[Dimension, str] = {}
        for symbol in self.types.values():
            if isinstance(symbol, symbols.QuantitySymbol):
                names.setdefault(symbol.dimension, symbol.name)
        return names
