"""Descriptions of declarations and types, as text and Markdown."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import assert_never

from seoro.lang import symbols
from seoro.lang.check.plan_types import type_name
from seoro.lang.comments import comment_above
from seoro.lang.program import EnumMember, Program
from seoro.lang.source import Span
from seoro.lang.units import unit_text
from seoro.lsp.meaning import ImportedFile, Label, Meaning, Occurrence, definition

LANGUAGE = "osc"  # of code blocks
MAX_LINES = 40  # of a shown declaration
_FENCE = re.compile(r"`{3,}")


def type_text(type_: symbols.Type, program: Program) -> str:
    """Format a type in the syntax of the language, if it has a name."""
    return type_name(type_, program).strip("`")


def unit_of(type_: symbols.Type) -> str:
    """Return the SI unit of physical values, or of lists and ranges of them; empty for others."""
    match type_:
        case symbols.Quantity(dimension):
            return unit_text(dimension)
        case symbols.ListOf(element) | symbols.RangeOf(element):
            return unit_of(element)
        case _:
            return ""


def typed(type_: symbols.Type, program: Program) -> str:
    """Format a type with its SI unit, in Markdown."""
    unit = unit_of(type_)
    name = type_name(type_, program)
    return f"{name} [{unit}]" if unit and unit not in name else name


def parameter_text(parameter: symbols.FieldSymbol, program: Program) -> str:
    """Format a parameter like a declaration, with its type and default."""
    default = f" = {' '.join(parameter.default.span.text.split())}" if parameter.default is not None else ""
    return f"{parameter.text}: {type_text(parameter.type, program)}{default}"


def signature(meaning: symbols.TypeSymbol | symbols.MethodSymbol | symbols.EventSymbol, program: Program) -> str:
    """Format a callable with its parameters, on one line."""
    parameters = parameters_of(meaning)
    text = ", ".join(parameter_text(parameter, program) for parameter in parameters.values())
    match meaning:
        case symbols.MethodSymbol(text=name, result=result):
            arrow = f" -> {type_text(result, program)}" if result is not None else ""
            return f"{name}({text}){arrow}"
        case symbols.EventSymbol(text=name):
            return f"{name}({text})" if text else name
        case symbols.TypeSymbol():
            return f"{meaning.qualified_name}({text})"


def parameters_of(
    meaning: symbols.TypeSymbol | symbols.MethodSymbol | symbols.EventSymbol,
) -> Mapping[str, symbols.FieldSymbol]:
    """Return the parameters of a callable."""
    return meaning.inventory.fields if isinstance(meaning, symbols.TypeSymbol) else meaning.parameters


def described(meaning: Meaning, program: Program) -> tuple[str, str]:
    """Return a declaration, shortened for its uses, and the kind, type and owner of the symbol, in Markdown."""
    match meaning:
        case symbols.TypeSymbol():
            base = f", inherits `{meaning.base.qualified_name}`" if meaning.base is not None else ""
            return _type_declaration(meaning, program), f"{meaning.kind.value}{base}"
        case EnumMember(enum, text):
            return f"{enum.name}!{text} = {enum.members[text]}", f"member of `{enum.name}`"
        case symbols.EnumSymbol():
            return f"enum {meaning.name}: [{', '.join(meaning.members)}]", "enumeration"
        case symbols.MethodSymbol(owner=owner, receiver=receiver):
            return f"def {signature(meaning, program)}", f"method of {_of(owner) or typed(receiver, program)}"
        case symbols.EventSymbol(owner=owner):
            return f"event {signature(meaning, program)}", f"event of {_of(owner)}"
        case symbols.FieldSymbol():
            return parameter_text(meaning, program), f"{_field_kind(meaning)}: {typed(meaning.type, program)}"
        case Label(span=span):
            return _line(span), "label"
        case Occurrence():
            return f"as {meaning.text}", "occurrence of an event"
        case ImportedFile(path, library):
            if library is not None:
                return f"import {library}", "library"
            return f'import "{path.name}"', "file"
        case symbols.QuantitySymbol(dimension=dimension):
            return _line(meaning.span), f"physical type, in {unit_text(dimension)}"
        case symbols.UnitSymbol():
            return _line(meaning.span), _unit_kind(meaning, program)
        case _:
            assert_never(meaning)


def _type_declaration(symbol: symbols.TypeSymbol, program: Program) -> str:
    lines = [_line(Span(symbol.span.file, symbol.declaration.span.start, symbol.span.end))]
    fields = [f"    {parameter_text(field, program)}" for field in symbol.inventory.fields.values()]
    lines[0] += ":" if fields else ""
    lines += fields[:MAX_LINES]
    lines += ["    ..."] if len(fields) > MAX_LINES else []
    return "\n".join(lines)


def _field_kind(field: symbols.FieldSymbol) -> str:
    owner = field.owner
    if owner is None:
        return "global parameter" if field.name.startswith("global ") else "parameter"
    if owner.fields.get(field.name) is not field:  # it belongs to an event or a method of the type
        return "parameter"
    return f"{'parameter' if symbols.has_phases(owner) else 'field'} of {_of(owner)}"


def _unit_kind(unit: symbols.UnitSymbol, program: Program) -> str:
    if unit.dimension is None:
        return "unit"
    quantity = program.quantities.get(unit.dimension)
    of = f" of `{quantity}`" if quantity is not None else ""
    offset = f" + {unit.offset:g}" if unit.offset else ""
    return f"unit{of}: 1 {unit.name} = {unit.factor:g}{offset} {unit_text(unit.dimension)}"


def _of(owner: symbols.TypeSymbol | None) -> str:
    return f"{owner.kind.value} `{owner.qualified_name}`" if owner is not None else ""


def comment(meaning: Meaning) -> str:
    """Return the `#` lines directly above a declaration."""
    span = meaning.declaration.span if isinstance(meaning, symbols.TypeSymbol) else definition(meaning)
    if span is None:
        return ""
    return comment_above(span.file, span.line)


def code(text: str) -> str:
    """Format a code block."""
    fence = max((found.group() for found in _FENCE.finditer(text)), key=len, default="``") + "`"
    return f"{fence}{LANGUAGE}\n{text}\n{fence}"


def _line(span: Span) -> str:
    """Return the first line of a span, without the colon of a block."""
    return span.file.line(span.line).strip().removesuffix(":")
