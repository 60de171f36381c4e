"""Runs the passes of checking over a loaded scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from seoro.lang import ast, plan
from seoro.lang.check.behaviors import Behaviors, Traits
from seoro.lang.check.declare import declare, declare_behaviors, declare_units
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.resolve import Resolver
from seoro.lang.diagnostic import Bag, Diagnostic, Severity
from seoro.lang.diagnostics import types as messages
from seoro.lang.loader import Sources
from seoro.lang.symbols import Kind, Program, TypeSymbol, do_directive

STANDARD_MODULES = ("osc.standard", "osc.standard.all", "osc.standard.types", "osc.standard.domain")


@dataclass(frozen=True)
class Checked:
    """What checking found out.

    Args:
        sources: What was checked.
        diagnostics: Everything that is to be said, sorted by file and place.
        scenarios: Names of the scenarios that the entry file declares, in its order.
        program: The declarations.
        behaviors: The behavior of each scenario and action that has one.
    """

    sources: Sources
    diagnostics: tuple[Diagnostic, ...]
    scenarios: tuple[str, ...]
    program: Program
    behaviors: Mapping[TypeSymbol, plan.Behavior]

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """Those diagnostics that keep the scenario from running."""
        return tuple(found for found in self.diagnostics if found.severity is Severity.ERROR)


def run_checks(sources: Sources, traits: Traits, strict: bool) -> Checked:
    """Check a loaded scenario; texts with syntax errors are not looked at any further."""
    bag = Bag()
    program = Program(sources.uses)
    expressions = Expressions(program, bag, strict)
    behaviors: dict[TypeSymbol, plan.Behavior] = {}
    if not sources.diagnostics:
        if strict:
            _note_libraries(sources, bag)
        declared = declare(sources, program, bag)
        declare_units(declared, program, bag)
        declare_behaviors(declared, program, bag)
        resolver = Resolver(program, bag)
        resolver.resolve()
        _check_fields(resolver.structured(), expressions)
        for symbol in program.behaviors.values():
            found = do_directive(symbol)
            if found is not None and found[0] is symbol:
                behavior = Behaviors(symbol, found[1], expressions, traits).elaborate()
                if behavior is not None:
                    behaviors[symbol] = behavior
    order = {module.file.name: number for number, module in enumerate(reversed(sources.modules))}
    found_all = (*sources.diagnostics, *bag.diagnostics)
    diagnostics = sorted(found_all, key=lambda found: (order.get(found.position[0], -1), *found.position[1:]))
    return Checked(sources, tuple(diagnostics), _scenarios(sources), program, behaviors)


def _check_fields(symbols: list[TypeSymbol], expressions: Expressions) -> None:
    """Check the default values of all fields and parameters of events."""
    for symbol in symbols:
        if symbol.kind in {Kind.STRUCT, Kind.ACTOR}:
            expressions.values.defaults(symbol)
        else:
            found = {field.name: expressions.values.default(field)[0] for field in symbol.fields.values()}
            given = {name: value for name, value in found.items() if value is not None}
            expressions.values.ordered(given, symbol.fields)
        for event in symbol.events.values():
            for parameter in event.parameters.values():
                expressions.values.default(parameter)


def _note_libraries(sources: Sources, bag: Bag) -> None:
    for statement in sources.entry.tree.statements:
        if isinstance(statement, ast.ImportModule):
            name = ".".join(statement.path)
            if name.startswith("osc.") and name not in STANDARD_MODULES:
                bag.add(messages.LibraryImport(statement.span, name))


def _scenarios(sources: Sources) -> tuple[str, ...]:
    statements = sources.entry.tree.statements
    declared = [statement.name for statement in statements if isinstance(statement, ast.ScenarioDeclaration)]
    return tuple(f"{name.actor.text}.{name.name.text}" if name.actor else name.name.text for name in declared)
