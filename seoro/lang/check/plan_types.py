"""Conversion of types and names of the checker for the plan and for messages."""

from __future__ import annotations

from typing import assert_never

from seoro.lang import plan, symbols
from seoro.lang.program import Program
from seoro.lang.types import STRING, dimension_of
from seoro.lang.units import Dimension, unit_text


def enum_value(symbol: symbols.EnumSymbol, member: str) -> plan.EnumValue:
    """Convert a member of an enumeration for the plan."""
    return plan.EnumValue(symbol.plan_name, member, symbol.members[member])


def plan_type(type_: symbols.Type, program: Program) -> plan.ValueType:
    """Convert a type for the plan."""
    match type_:
        case symbols.Primitive(name):
            return plan.PrimitiveType(name)
        case symbols.Quantity(dimension):
            unit = unit_text(dimension)
            name = program.quantities.get(dimension, unit)
            return plan.PhysicalType(name, unit, base_unit(dimension, program))
        case symbols.Enumeration() | symbols.Structured():
            return type_.symbol.plan_type
        case symbols.ListOf(element):
            return plan.ListType(plan_type(element, program))
        case symbols.RangeOf(element):
            return plan.RangeType(plan_type(element, program))
        case symbols.EventObject() | symbols.CompositionObject() | symbols.Unknown():
            return plan_type(STRING, program)  # only after errors, which prevent a plan
        case _:
            assert_never(type_)


def base_unit(dimension: Dimension, program: Program) -> str:
    """Return the shortest name of the base unit of a dimension; empty if none is declared."""
    names = (
        unit.name
        for unit in program.units.values()
        if unit.dimension == dimension and unit.factor == 1 and not unit.offset
    )
    return min(names, key=len, default="")


def units_of(type_: symbols.Type, program: Program) -> tuple[str, ...]:
    """Return the units of a physical type, the SI unit first; empty for other types."""
    units = program.units.values() if isinstance(type_, symbols.Quantity) else ()
    fitting = [unit for unit in units if unit.dimension == dimension_of(type_)]
    fitting.sort(key=lambda unit: (unit.factor != 1 or unit.offset != 0, len(unit.name)))
    return tuple(unit.name for unit in fitting)


def type_name(type_: symbols.Type, program: Program) -> str:
    """Describe a type for messages, quoted."""
    match type_:
        case symbols.Quantity(dimension) if dimension not in program.quantities:
            return f"a value in {unit_text(dimension)}"
        case symbols.EventObject(symbol):
            return f"an occurrence of `{symbol.name}`"
        case _:
            return f"`{_bare_name(type_, program)}`"


def _bare_name(type_: symbols.Type, program: Program) -> str:
    match type_:
        case symbols.Primitive(name):
            return name
        case symbols.Quantity(dimension):
            return program.quantities.get(dimension) or unit_text(dimension)
        case symbols.Enumeration() | symbols.Structured() | symbols.EventObject() | symbols.CompositionObject():
            return type_.symbol.name
        case symbols.ListOf(element):
            return f"list of {_bare_name(element, program)}"
        case symbols.RangeOf(element):
            return f"range of {_bare_name(element, program)}"
        case symbols.Unknown():
            return "unknown"
        case _:
            assert_never(type_)
