"""Completion items, by sort."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from lsprotocol.types import CompletionItemKind as Sort

from seoro.lang import plan, symbols
from seoro.lang.check.builtins import Builtins
from seoro.lang.libraries import library_files
from seoro.lang.program import Declaration, Program
from seoro.lang.types import BOOL, PRIMITIVES, is_number, quantity
from seoro.lang.units import unit_text
from seoro.lsp.cursor_context import CursorContext
from seoro.lsp.describe import comment, parameter_text, signature, type_text

FIRST, SOON, LATER, LAST = range(4)  # likelihood of an item
SORTS = {
    symbols.Kind.STRUCT: Sort.Struct,
    symbols.Kind.ACTOR: Sort.Class,
    symbols.Kind.SCENARIO: Sort.Function,
    symbols.Kind.ACTION: Sort.Function,
    symbols.Kind.MODIFIER: Sort.Operator,
}


@dataclass(frozen=True)
class Item:
    """A completion item.

    Args:
        label: Shown text; also inserted unless `insert` is set.
        sort: Its sort.
        detail: Its type, or its declaration.
        documentation: Comment of its declaration.
        insert: Inserted text.
        rank: Its likelihood.
    """

    label: str
    sort: Sort
    detail: str = ""
    documentation: str = ""
    insert: str | None = None
    rank: int = SOON


def keywords(words: Iterable[str], rank: int = LATER) -> Iterable[Item]:
    """Yield keywords."""
    return (Item(word, Sort.Keyword, rank=rank) for word in words)


def modules(typed: str, document: Path | None) -> Iterable[Item]:
    """Yield libraries that a document can import and whose names match the typed text up to a dot."""
    names = sorted(library_files(document))
    return (Item(name, Sort.Module, "library") for name in names if name.startswith(typed))


def units(program: Program, expected: symbols.Type | None) -> Iterable[Item]:
    """Yield all units; those of the expected type first."""
    for unit in program.units.values():
        if unit.dimension is not None:
            name = program.quantities.get(unit.dimension, unit_text(unit.dimension))
            offset = f" + {unit.offset:g}" if unit.offset else ""
            detail = f"{name}: {unit.factor:g}{offset} {unit_text(unit.dimension)}"
            rank = FIRST if quantity(unit.dimension) == expected else LATER
            yield Item(unit.name, Sort.Unit, detail, rank=rank)


def field(symbol: symbols.FieldSymbol, program: Program, rank: int = SOON, insert: str | None = None) -> Item:
    """Create the item of a field or a parameter."""
    detail = parameter_text(symbol, program).partition(": ")[2]
    return Item(symbol.text, Sort.Field, detail, comment(symbol), insert, rank)


def arguments(parameters: Iterable[symbols.FieldSymbol], program: Program) -> Iterable[Item]:
    """Yield names of arguments."""
    return (field(parameter, program, FIRST, f"{parameter.text}: ") for parameter in parameters)


def method(symbol: symbols.MethodSymbol, program: Program) -> Item:
    """Create the item of a method."""
    return Item(symbol.text, Sort.Method, signature(symbol, program), comment(symbol))


def event(symbol: symbols.EventSymbol, program: Program) -> Item:
    """Create the item of an event."""
    return Item(symbol.text, Sort.Event, signature(symbol, program), comment(symbol), rank=FIRST)


def enum_members(enum: symbols.EnumSymbol, rank: int = FIRST) -> Iterable[Item]:
    """Yield the members of an enumeration."""
    members_ = enum.members.items()
    return (Item(name, Sort.EnumMember, f"{enum.name} = {number}", rank=rank) for name, number in members_)


def type_name(label: str, symbol: Declaration, rank: int = SOON) -> Item:
    """Create the item of a type."""
    match symbol:
        case symbols.QuantitySymbol(dimension=dimension):
            return Item(label, Sort.Unit, f"physical type [{unit_text(dimension)}]", comment(symbol), rank=rank)
        case symbols.EnumSymbol():
            return Item(label, Sort.Enum, "enumeration", comment(symbol), rank=rank)
        case symbols.TypeSymbol():
            return Item(label, SORTS[symbol.kind], symbol.kind.value, comment(symbol), rank=rank)


def behavior(label: str, symbol: symbols.TypeSymbol, program: Program, rank: int = SOON) -> Item:
    """Create the item of a scenario, action or modifier."""
    return Item(label, SORTS[symbol.kind], signature(symbol, program), comment(symbol), rank=rank)


# ---------------------------------------------------------------- groups


def types(around: CursorContext, kinds: Iterable[symbols.Kind] | None = None) -> Iterable[Item]:
    """Yield the visible types, optionally of some kinds only."""
    if kinds is None:
        yield from (Item(name, Sort.Keyword, "primitive type", rank=LATER) for name in PRIMITIVES)
        yield from (Item(word, Sort.Keyword, rank=LATER) for word in ("list of", "range of"))
    for label, symbol in around.types():
        if kinds is None or (isinstance(symbol, symbols.TypeSymbol) and symbol.kind in kinds):
            rank = FIRST if symbol.home.library is None else SOON
            yield type_name(label, symbol, rank)


def physical_types(around: CursorContext) -> Iterable[Item]:
    """Yield the physical types."""
    return (
        type_name(label, symbol) for label, symbol in around.types() if isinstance(symbol, symbols.QuantitySymbol)
    )


def behaviors(around: CursorContext, actor: symbols.TypeSymbol | None, rank: int = FIRST) -> Iterable[Item]:
    """Yield the scenarios and actions of an actor and its bases, or of none."""
    yield from _of_actor(around, around.program.behaviors.values(), actor, rank)


def modifiers(around: CursorContext, actor: symbols.TypeSymbol | None) -> Iterable[Item]:
    """Yield the modifiers of an actor and its bases, or of none."""
    yield from _of_actor(around, around.program.modifiers.values(), actor, SOON)


def _of_actor(
    around: CursorContext, table: Iterable[symbols.TypeSymbol], actor: symbols.TypeSymbol | None, rank: int
) -> Iterable[Item]:
    owners = set(symbols.lineage(actor)) if actor is not None else {None}
    found = [symbol for symbol in table if symbol.actor in owners]
    return (behavior(label, symbol, around.program, rank) for label, symbol in around.behaviors(found))


def members(type_: symbols.Type, program: Program) -> Iterable[Item]:
    """Yield the members of a value, after its dot."""
    match type_:
        case symbols.Structured(symbol):
            yield from (field(found, program, FIRST) for found in symbol.inventory.fields.values())
            yield from (method(found, program) for found in symbol.inventory.methods.values())
        case symbols.EventObject(symbol):
            yield from (field(found, program, FIRST) for found in symbol.parameters.values())
        case symbols.CompositionObject(symbol):
            for found in symbol.parameters.values():
                yield Item(found.text, Sort.Field, type_text(found.type, program), rank=FIRST)
        case symbols.Primitive(name):
            yield from (method(found, program) for found in program.primitives.get(name, {}).values())
        case _:
            pass
    for name in Builtins.names(type_):
        yield Item(name, Sort.Method, f"of {type_text(type_, program)}")
    yield from (Item(word, Sort.Keyword, rank=LAST) for word in ("as", "is"))


def events(around: CursorContext, owner: symbols.TypeSymbol | None) -> Iterable[Item]:
    """Yield the events of a type, and the predefined ones."""
    return (*declared_events(around, owner), *phases())


def declared_events(around: CursorContext, owner: symbols.TypeSymbol | None) -> Iterable[Item]:
    """Yield the events that a type and its bases declare."""
    found = owner.inventory.events.values() if owner is not None else ()
    return (event(symbol, around.program) for symbol in found)


def phases() -> Iterable[Item]:
    """Yield the predefined events of behaviors."""
    return (Item(phase.value, Sort.Event, "built-in event") for phase in plan.Phase)


def values(around: CursorContext, expected: symbols.Type | None) -> Iterable[Item]:
    """Yield values; those of the expected type first."""
    program, scope = around.program, around.scope
    if isinstance(expected, symbols.Enumeration):
        yield from enum_members(expected.symbol)
    for name, type_ in scope.bindings.items():
        yield Item(name, Sort.Variable, type_text(type_, program), rank=_rank(type_, expected))
    for found in (*scope.fields.values(), *program.globals.values()):
        yield field(found, program, _rank(found.type, expected))
    if around.owner is not None:
        yield from (method(found, program) for found in around.owner.inventory.methods.values())
    for label, symbol in around.types():
        if isinstance(symbol, symbols.TypeSymbol) and symbol.kind is symbols.Kind.STRUCT:
            is_needed = expected == symbols.Structured(symbol)
            detail = signature(symbol, program)
            yield Item(label, Sort.Constructor, detail, comment(symbol), rank=FIRST if is_needed else LATER)
        elif isinstance(symbol, symbols.EnumSymbol):
            yield type_name(label, symbol, LATER)
    yield from keywords(("true", "false"), FIRST if expected == BOOL else LAST)
    yield from keywords(("it", "not"), LAST)


def _rank(type_: symbols.Type, expected: symbols.Type | None) -> int:
    both_numbers = expected is not None and not isinstance(expected, symbols.Structured) and is_number(type_)
    if type_ == expected:
        return FIRST
    return SOON if expected is None or (both_numbers and is_number(expected)) else LATER
