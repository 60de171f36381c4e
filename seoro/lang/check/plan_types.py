"""Types and names of checking, as the plan and as messages have them."""

from __future__ import annotations

from typing import assert_never

from seoro.lang import plan
from seoro.lang.symbols import EnumSymbol, Program
from seoro.lang.types import (
    STRING,
    CompositionObject,
    Enumeration,
    EventObject,
    ListOf,
    Primitive,
    Quantity,
    RangeOf,
    Structured,
    Type,
    Unknown,
)
from seoro.lang.units import Dimension, unit_text


def enum_value(symbol: EnumSymbol, member: str) -> plan.EnumValue:
    """A member of an enumeration as the plan has it."""
    return plan.EnumValue(symbol.plan_name, member, symbol.members[member])


def plan_type(type_: Type, program: Program) -> plan.ValueType:
    """A type as the plan has it."""
    match type_:
        case Primitive(name):
            return plan.PrimitiveType(name)
        case Quantity(dimension):
            unit = unit_text(dimension)
            name = program.quantities.get(dimension, unit)
            return plan.PhysicalType(name, unit, base_unit(dimension, program))
        case Enumeration(symbol):
            return symbol.plan_type
        case Structured(symbol):
            return symbol.plan_type
        case ListOf(element):
            return plan.ListType(plan_type(element, program))
        case RangeOf(element):
            return plan.RangeType(plan_type(element, program))
        case EventObject() | CompositionObject() | Unknown():
            return plan_type(STRING, program)  # only where checking failed, and no plan is made
        case _:
            assert_never(type_)


def base_unit(dimension: Dimension, program: Program) -> str:
    """The shortest name of a unit that is the base unit of a dimension; empty if none is declared."""
    names = (
        unit.name
        for unit in program.units.values()
        if unit.dimension == dimension and unit.factor == 1 and not unit.offset
    )
    return min(names, key=len, default="")


def type_name(type_: Type, program: Program) -> str:
    """A type for messages, quoted."""
    match type_:
        case Quantity(dimension) if dimension not in program.quantities:
            return f"a value in {unit_text(dimension)}"
        case EventObject(symbol):
            return f"an occurrence of `{symbol.name}`"
        case _:
            return f"`{_bare_name(type_, program)}`"


def _bare_name(type_: Type, program: Program) -> str:
    match type_:
        case Primitive(name):
            return name
        case Quantity(dimension):
            return program.quantities.get(dimension) or unit_text(dimension)
        case Enumeration(symbol):
            return symbol.name
        case Structured(symbol):
            return symbol.name
        case ListOf(element):
            return f"list of {_bare_name(element, program)}"
        case RangeOf(element):
            return f"range of {_bare_name(element, program)}"
        case EventObject(event):
            return event.name
        case CompositionObject(composition):
            return composition.name
        case Unknown():
            return "unknown"
        case _:
            assert_never(type_)
