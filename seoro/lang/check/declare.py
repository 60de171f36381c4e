"""First pass: every declaration gets a symbol; names that are declared twice are reported (7.3.15: in any
order)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

from seoro.lang import ast
from seoro.lang.check.unsupported import refuse_statement
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import names
from seoro.lang.diagnostics import types as messages
from seoro.lang.loader import Module, Sources
from seoro.lang.source import Span
from seoro.lang.symbols import (
    GLOBAL_NAMESPACE,
    EnumSymbol,
    Home,
    Kind,
    Program,
    QuantitySymbol,
    TypeSymbol,
    UnitSymbol,
)
from seoro.lang.units import BASE_UNITS, Dimension, dimension, unit_text

_BehaviorDeclaration = ast.ScenarioDeclaration | ast.ActionDeclaration | ast.ModifierDeclaration


@dataclass
class Declared:
    """What the pass leaves for the next one: declarations whose actor is still a name."""

    behaviors: list[tuple[_BehaviorDeclaration, Home]]
    units: list[tuple[ast.UnitDeclaration, Home]]


def declare(sources: Sources, program: Program, bag: Bag) -> Declared:
    """Declare types; collect units and behaviors, which need the types of all files."""
    declared = Declared([], [])
    for module in sources.modules:
        namespace = GLOBAL_NAMESPACE
        for statement in module.tree.statements:
            if module.library is None and refuse_statement(statement, program, bag):
                continue
            if isinstance(statement, ast.NamespaceStatement):
                namespace = statement.name
            else:
                _declare(statement, module, Home(namespace, module.library), program, declared, bag)
    for kind in program.types.values():
        if isinstance(kind, EnumSymbol):
            for member in kind.declaration.members:
                holders = program.holders.setdefault(member.name.text, [])
                if kind not in holders:
                    holders.append(kind)
    return declared


def _declare(
    statement: ast.Statement, module: Module, home: Home, program: Program, declared: Declared, bag: Bag
) -> None:
    match statement:
        case ast.PhysicalTypeDeclaration(name, exponents):
            _add_type(program, QuantitySymbol(name.text, home, _dimension(exponents, bag), name.span), home, bag)
        case ast.UnitDeclaration():
            declared.units.append((statement, home))
        case ast.EnumDeclaration(name):
            _add_type(program, EnumSymbol(name.text, home, statement, name.span), home, bag)
        case ast.StructDeclaration(name):
            _add_type(program, TypeSymbol(Kind.STRUCT, name.text, home, statement, name.span), home, bag)
        case ast.ActorDeclaration(name):
            _add_type(program, TypeSymbol(Kind.ACTOR, name.text, home, statement, name.span), home, bag)
        case ast.ScenarioDeclaration() | ast.ActionDeclaration() | ast.ModifierDeclaration():
            declared.behaviors.append((statement, home))
        case (
            ast.ImportModule()
            | ast.ImportUri()
            | ast.NamespaceStatement()
            | ast.ExportStatement()
            | ast.InvalidStatement()
            | ast.EnumTypeExtension()
            | ast.StructuredTypeExtension()
            | ast.PrimitiveTypeExtension()
            | ast.GlobalParameterDeclaration()
        ):
            pass
        case _:
            assert_never(statement)


def _add_type(program: Program, symbol: QuantitySymbol | EnumSymbol | TypeSymbol, home: Home, bag: Bag) -> None:
    key = (home.namespace, symbol.name)
    first = program.types.setdefault(key, symbol)
    if first is not symbol and not program.is_lenient:
        bag.add(names.Duplicate(symbol.span, "type", symbol.name, first.span))


def _dimension(exponents: tuple[ast.SiBaseExponent, ...], bag: Bag) -> Dimension:
    found: dict[str, int] = {}
    for exponent in exponents:
        if exponent.unit not in BASE_UNITS:
            span = Span(exponent.span.file, exponent.span.start, exponent.span.start + len(exponent.unit))
            bag.add(names.UnknownBaseUnit(span, exponent.unit, BASE_UNITS))
        elif exponent.unit in found:
            bag.add(names.Duplicate(exponent.span, "base unit", exponent.unit, exponents[0].span))
        found[exponent.unit] = exponent.exponent
    return dimension({unit: power for unit, power in found.items() if unit in BASE_UNITS})


def declare_units(declared: Declared, program: Program, bag: Bag) -> None:
    """Declare units, whose types are known now; unit names are global, whatever the namespace (7.3.4)."""
    for unit, home in declared.units:
        name = unit.name.text
        found = _dimension(unit.exponents, bag)
        of: Dimension | None = found
        quantity = program.find_type(home.namespace, unit.quantity)
        if not isinstance(quantity, QuantitySymbol):
            of = None
            if quantity is None:
                known = tuple(s.name for s in program.types.values() if isinstance(s, QuantitySymbol))
                bag.add(names.UnknownType(unit.quantity.span, unit.quantity.text, known, "physical type"))
            else:
                bag.add(
                    names.WrongKind(unit.quantity.span, quantity.name, describe_kind(quantity), "a physical type")
                )
        elif quantity.dimension != found:
            of = None
            needed, given = unit_text(quantity.dimension), unit_text(found)
            bag.add(messages.WrongUnitDimension(unit.name.span, name, quantity.name, needed, given))
        symbol = UnitSymbol(name, of, unit.factor, unit.offset, unit.name.span)
        first = program.units.setdefault(name, symbol)
        if first is not symbol:
            bag.add(names.Duplicate(unit.name.span, "unit", name, first.span))


def declare_behaviors(declared: Declared, program: Program, bag: Bag) -> None:
    """Declare scenarios, actions and modifiers with the actors that they belong to."""
    kinds = {ast.ScenarioDeclaration: Kind.SCENARIO, ast.ActionDeclaration: Kind.ACTION}
    for declaration, home in declared.behaviors:
        name = declaration.name
        kind = kinds.get(type(declaration), Kind.MODIFIER)
        actor: TypeSymbol | None = None
        if name.actor is not None:
            found = program.find_type(home.namespace, name.actor)
            if isinstance(found, TypeSymbol) and found.kind is Kind.ACTOR:
                actor = found
            else:
                _report_actor(found, name.actor, program, bag)
                continue
        symbol = TypeSymbol(kind, name.name.text, home, declaration, name.span, actor)
        table = program.modifiers if kind is Kind.MODIFIER else program.behaviors
        first = table.setdefault((home.namespace, actor, symbol.name), symbol)
        if first is not symbol and not program.is_lenient:
            bag.add(names.Duplicate(name.span, kind.value, symbol.qualified_name, first.span))


def _report_actor(
    found: QuantitySymbol | EnumSymbol | TypeSymbol | None, name: ast.Name, program: Program, bag: Bag
) -> None:
    if found is not None:
        bag.add(names.WrongKind(name.span, name.text, describe_kind(found), "an actor"))
    elif not program.is_lenient:
        actors = tuple(
            s.name for s in program.types.values() if isinstance(s, TypeSymbol) and s.kind is Kind.ACTOR
        )
        bag.add(names.UnknownType(name.span, name.text, actors, "actor"))


def describe_kind(symbol: QuantitySymbol | EnumSymbol | TypeSymbol) -> str:
    """What a symbol is, for messages."""
    if isinstance(symbol, QuantitySymbol):
        return "a physical type"
    if isinstance(symbol, EnumSymbol):
        return "an enumeration"
    return f"a{'n' if symbol.kind.value[0] == 'a' else ''} {symbol.kind.value}"
