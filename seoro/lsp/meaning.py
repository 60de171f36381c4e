"""Meanings of names for editors, and their declarations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias, assert_never

from seoro.lang import ast, symbols
from seoro.lang.program import EnumMember, Program
from seoro.lang.source import Span


@dataclass(frozen=True)
class Label:
    """The label of a behavior; `span` is its declaration."""

    text: str
    span: Span
    body: ast.DoBody


@dataclass(frozen=True)
class Occurrence:
    """The name that an `as` clause gives to an occurrence of an event."""

    text: str
    span: Span


@dataclass(frozen=True)
class ImportedFile:
    """The file that an import statement reads."""

    path: Path
    library: str | None


Meaning: TypeAlias = (
    symbols.QuantitySymbol
    | symbols.EnumSymbol
    | symbols.TypeSymbol
    | symbols.UnitSymbol
    | symbols.FieldSymbol
    | symbols.EventSymbol
    | symbols.MethodSymbol
    | EnumMember
    | Label
    | Occurrence
    | ImportedFile
)


def definition(meaning: Meaning) -> Span | None:
    """Return the name in the declaration; None without one in a text, or if it is invalid."""
    match meaning:
        case symbols.TypeSymbol():
            return type_name_span(meaning)
        case EnumMember(enum, text):
            return next((member.name.span for member, _ in enum.declared if member.name.text == text), None)
        case ImportedFile():
            return None
        case _:
            return meaning.span


def type_name_span(symbol: symbols.TypeSymbol) -> Span:
    """Return the name of a type in its declaration, without its actor."""
    name = symbol.declaration.name
    return name.name.span if isinstance(name, ast.BehaviorName) else name.span


def name_of(meaning: Meaning) -> str:
    """Return the identifier of a symbol."""
    match meaning:
        case (
            symbols.FieldSymbol()
            | symbols.EventSymbol()
            | symbols.MethodSymbol()
            | EnumMember()
            | Label()
            | Occurrence()
        ):
            return meaning.text
        case symbols.QuantitySymbol() | symbols.EnumSymbol() | symbols.TypeSymbol() | symbols.UnitSymbol():
            return meaning.name
        case ImportedFile(path):
            return path.name
        case _:
            assert_never(meaning)


def declarations(program: Program) -> Iterator[Meaning]:
    """Yield all declarations of a program."""
    for symbol in program.types.values():
        yield symbol
        if isinstance(symbol, symbols.EnumSymbol):
            yield from (EnumMember(symbol, text) for text in symbol.members)
    yield from program.behaviors.values()
    yield from program.modifiers.values()
    yield from program.units.values()
    yield from program.globals.values()
    for type_ in program.structured():
        yield from type_.fields.values()
        for event in type_.events.values():
            yield event
            yield from event.parameters.values()
        yield from _methods(type_.methods.values())
    for methods in program.primitives.values():
        yield from _methods(methods.values())


def _methods(methods: Iterable[symbols.MethodSymbol]) -> Iterator[Meaning]:
    for method in methods:
        yield method
        yield from method.parameters.values()
