"""First pass: create a symbol for each declaration, in any order (7.3.15); report duplicates."""

from __future__ import annotations

from dataclasses import field
from typing import assert_never

from seoro.deferred import dataclass
from seoro.lang import ast
from seoro.lang.check.lookup import Lookup
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import modifiers, names, types
from seoro.lang.loader import Module, Sources
from seoro.lang.namespaces import GLOBAL_NAMESPACE, Export, Home, Space
from seoro.lang.program import Declaration, Program
from seoro.lang.source import Span
from seoro.lang.symbols import EnumSymbol, FieldSymbol, Kind, QuantitySymbol, TypeSymbol, UnitSymbol
from seoro.lang.types import UNKNOWN
from seoro.lang.units import BASE_UNITS, Dimension, dimension, unit_text

OVERRIDE = "override"  # the modifier that is part of the language (7.3.12.1.1)
RESERVED_NAMESPACES = "std"  # prefix of the standard's own namespaces
_BehaviorDeclaration = ast.ScenarioDeclaration | ast.ActionDeclaration | ast.ModifierDeclaration
_Extension = ast.EnumTypeExtension | ast.StructuredTypeExtension | ast.PrimitiveTypeExtension


@dataclass(eq=False)
class Declared:
    """Declarations for the next passes, which refer to types by name."""

    behaviors: list[tuple[_BehaviorDeclaration, Home]] = field(default_factory=list)
    units: list[tuple[ast.UnitDeclaration, Home]] = field(default_factory=list)
    extensions: list[tuple[_Extension, Home]] = field(default_factory=list)
    globals: list[tuple[ast.ParameterDeclaration, Home]] = field(default_factory=list)
    spaces: list[tuple[ast.NamespaceStatement, Home]] = field(default_factory=list)


def declare(sources: Sources, program: Program, bag: Bag) -> Declared:
    """Declare types and namespaces; collect declarations that need the types of all files."""
    declared = Declared()
    for module in sources.modules:
        home = Home(Space(GLOBAL_NAMESPACE, sources.uses), module.library)
        for statement in module.tree.statements:
            _define(statement, home, program)
            if isinstance(statement, ast.NamespaceStatement):
                home = Home(Space(statement.name, frozenset(statement.uses)), module.library)
                declared.spaces.append((statement, home))
            else:
                _declare(statement, module, home, program, declared, bag)
    return declared


def check_namespaces(declared: Declared, program: Program, bag: Bag) -> None:
    """Report unknown namespaces and unknown exported names."""
    lookup = Lookup(program, bag)
    known = {GLOBAL_NAMESPACE, *(namespace for namespace, _ in program.defined), *program.exports}
    known |= {statement.name for statement, _ in declared.spaces}
    for statement, _ in declared.spaces:
        for used in statement.uses:
            if used not in known:
                bag.add(names.unknown_namespace, statement.span, used, tuple(known))
    for namespace, exports in program.exports.items():
        for item in (item for items in exports.values() for item in items):
            if item.name is not None and not lookup.exported(namespace, item.name):
                text = f"{item.namespace}::{item.name}" if item.namespace else item.name
                bag.add(names.unknown_export, item.span, text)
            elif item.name is None and item.namespace is not None and item.namespace not in known:
                bag.add(names.unknown_namespace, item.span, item.namespace, tuple(known))


def _define(statement: ast.Statement, home: Home, program: Program) -> None:
    """Record all identifiers that a statement defines, for export lists."""
    found: list[ast.Name] = []
    match statement:
        case ast.StructDeclaration(name) | ast.ActorDeclaration(name) | ast.PhysicalTypeDeclaration(name):
            found.append(name)
        case ast.ScenarioDeclaration(name) | ast.ActionDeclaration(name) | ast.ModifierDeclaration(name):
            found.append(name.name)
        case ast.EnumDeclaration(name, members):
            found += [name, *(member.name for member in members)]
        case ast.EnumTypeExtension(_, members):
            found += [member.name for member in members]
        case ast.GlobalParameterDeclaration(parameter):
            found += parameter.names
        case _:
            pass
    if isinstance(
        statement,
        ast.StructuredTypeDeclaration | ast.StructuredTypeExtension | ast.PrimitiveTypeExtension,
    ):
        for member in statement.members:
            match member:
                case ast.ParameterDeclaration(names_) | ast.VariableDeclaration(names_):
                    found += names_
                case ast.EventDeclaration(name) | ast.MethodDeclaration(name):
                    found.append(name)
                case _:
                    pass
    program.defined.update((home.namespace_of(name), name.text) for name in found)


def _declare(
    statement: ast.Statement, module: Module, home: Home, program: Program, declared: Declared, bag: Bag
) -> None:
    match statement:
        case ast.PhysicalTypeDeclaration(name, exponents):
            space, found = home.namespace_of(name), _dimension(exponents, bag)
            _add_type(program, QuantitySymbol(name.text, space, home, found, name.span), bag)
        case ast.UnitDeclaration():
            declared.units.append((statement, home))
        case ast.EnumDeclaration(name, members):
            enum = EnumSymbol(name.text, home.namespace_of(name), home, name.span)
            enum.declared += [(member, home) for member in members]
            _add_type(program, enum, bag)
        case ast.StructDeclaration(name) | ast.ActorDeclaration(name):
            kind = Kind.STRUCT if isinstance(statement, ast.StructDeclaration) else Kind.ACTOR
            symbol = TypeSymbol(kind, name.text, home.namespace_of(name), home, statement, name.span)
            _add_type(program, symbol, bag)
        case ast.ScenarioDeclaration() | ast.ActionDeclaration() | ast.ModifierDeclaration():
            declared.behaviors.append((statement, home))
        case ast.EnumTypeExtension() | ast.StructuredTypeExtension() | ast.PrimitiveTypeExtension():
            declared.extensions.append((statement, home))
        case ast.GlobalParameterDeclaration(parameter):
            declared.globals.append((parameter, home))
            program.global_declarations.append((parameter, home))
            _declare_globals(parameter, home, program, bag)
        case ast.ExportStatement(items):
            exports = program.exports.setdefault(home.space.name, {})
            for item in items:
                name_ = item.text if isinstance(item, ast.Name) else None
                exports.setdefault(name_, []).append(Export(item.namespace, name_, home, item.span))
        case ast.ImportModule() | ast.ImportUri() | ast.NamespaceStatement() | ast.InvalidStatement():
            pass
        case _:
            assert_never(statement)


def _declare_globals(parameter: ast.ParameterDeclaration, home: Home, program: Program, bag: Bag) -> None:
    """Declare global parameters; their type is resolved later (7.3.14)."""
    for name in parameter.names:
        space = home.namespace_of(name)
        unique = f"global {space}::{name.text}"
        symbol = FieldSymbol(unique, UNKNOWN, parameter.default, None, name.span, home, name.text, space)
        first = program.globals.setdefault((space, name.text), symbol)
        if first is not symbol:
            bag.add(names.duplicate, name.span, "global parameter", name.text, first.span)


def _add_type(program: Program, symbol: Declaration, bag: Bag) -> None:
    key = (symbol.namespace, symbol.name)
    first = program.types.setdefault(key, symbol)
    if first is not symbol and not program.is_unread(symbol.name):
        bag.add(names.duplicate, symbol.span, "type", symbol.name, first.span)


def name_for_plan(program: Program) -> None:
    """Give types, behaviors and modifiers unique names for the plan.

    A name has its namespace, unless that is the global one, or one of the standard and the bare name is free.
    """
    for symbol in program.types.values():
        if not isinstance(symbol, QuantitySymbol):
            is_free = (GLOBAL_NAMESPACE, symbol.name) not in program.types
            symbol.plan_name = _plan_name(symbol.namespace, symbol.name, is_free)
    for table in (program.behaviors, program.modifiers):
        for behavior in table.values():
            is_free = (GLOBAL_NAMESPACE, behavior.actor, behavior.name) not in table
            name = _plan_name(behavior.namespace, behavior.name, is_free)
            behavior.plan_name = f"{behavior.actor.plan_name}.{name}" if behavior.actor is not None else name


def _plan_name(namespace: str, name: str, is_free: bool) -> str:
    is_bare = namespace == GLOBAL_NAMESPACE or (is_free and namespace.startswith(RESERVED_NAMESPACES))
    return name if is_bare else f"{namespace}::{name}"


def _dimension(exponents: tuple[ast.SiBaseExponent, ...], bag: Bag) -> Dimension:
    found: dict[str, int] = {}
    for exponent in exponents:
        if exponent.unit not in BASE_UNITS:
            span = Span(exponent.span.file, exponent.span.start, exponent.span.start + len(exponent.unit))
            bag.add(names.unknown_base_unit, span, exponent.unit, BASE_UNITS)
        elif exponent.unit in found:
            bag.add(names.duplicate, exponent.span, "base unit", exponent.unit, exponents[0].span)
        found[exponent.unit] = exponent.exponent
    return dimension({unit: power for unit, power in found.items() if unit in BASE_UNITS})


def declare_units(declared: Declared, program: Program, bag: Bag) -> None:
    """Declare units, whose types are known now; unit names have no namespace (7.3.4)."""
    lookup = Lookup(program, bag)
    for unit, home in declared.units:
        name = unit.name.text
        found = _dimension(unit.exponents, bag)
        of: Dimension | None = found
        quantity = lookup.type(home.space, unit.quantity)
        if not isinstance(quantity, QuantitySymbol):
            of = None
            if quantity is None:
                known = program.types_of(QuantitySymbol)
                bag.add(names.unknown_type, unit.quantity.span, unit.quantity.text, known, "physical type")
            else:
                bag.add(
                    names.wrong_kind, unit.quantity.span, quantity.name, describe_kind(quantity), "a physical type"
                )
        elif quantity.dimension != found:
            of = None
            needed, given = unit_text(quantity.dimension), unit_text(found)
            bag.add(types.wrong_unit_dimension, unit.name.span, name, quantity.name, needed, given)
        symbol = UnitSymbol(name, of, unit.factor, unit.offset, unit.name.span)
        first = program.units.setdefault(name, symbol)
        if first is not symbol:
            bag.add(names.duplicate, unit.name.span, "unit", name, first.span)


def declare_behaviors(declared: Declared, program: Program, bag: Bag) -> None:
    """Declare scenarios, actions and modifiers with the actors that they belong to."""
    lookup = Lookup(program, bag)
    kinds = {ast.ScenarioDeclaration: Kind.SCENARIO, ast.ActionDeclaration: Kind.ACTION}
    for declaration, home in declared.behaviors:
        name = declaration.name
        kind = kinds.get(type(declaration), Kind.MODIFIER)
        actor: TypeSymbol | None = None
        if name.actor is not None:
            found = lookup.type(home.space, name.actor)
            if isinstance(found, TypeSymbol) and found.kind is Kind.ACTOR:
                actor = found
            else:
                _report_actor(found, name.actor, program, bag)
                continue
        if kind is Kind.MODIFIER and actor is None and name.name.text == OVERRIDE:
            bag.add(modifiers.override_declared, name.span)
        namespace = home.namespace_of(name.name)
        symbol = TypeSymbol(kind, name.name.text, namespace, home, declaration, name.span, actor)
        table = program.modifiers if kind is Kind.MODIFIER else program.behaviors
        first = table.setdefault((namespace, actor, symbol.name), symbol)
        if first is not symbol and not program.is_unread(symbol.name):
            bag.add(names.duplicate, name.span, kind.value, symbol.qualified_name, first.span)


def _report_actor(found: Declaration | None, name: ast.Name, program: Program, bag: Bag) -> None:
    if found is not None:
        bag.add(names.wrong_kind, name.span, name.text, describe_kind(found), "an actor")
    elif not program.is_unread(name.text):
        bag.add(names.unknown_type, name.span, name.text, program.types_of(Kind.ACTOR), "actor")


def describe_kind(symbol: Declaration) -> str:
    """Describe the kind of a symbol, for messages."""
    if isinstance(symbol, QuantitySymbol):
        return "a physical type"
    if isinstance(symbol, EnumSymbol):
        return "an enumeration"
    return f"a{'n' if symbol.kind.value[0] == 'a' else ''} {symbol.kind.value}"
