"""Entry point: run the passes of checking over a loaded scenario."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from seoro.lang import ast, plan
from seoro.lang.check import body_cache, declare, members, resolve
from seoro.lang.check.arguments import NO_TRAITS, Traits
from seoro.lang.check.coverage import Coverage
from seoro.lang.check.defaults import check_containment
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.reactions import Reactions
from seoro.lang.diagnostic import Bag, Diagnostic, Severity
from seoro.lang.diagnostics import types as messages
from seoro.lang.frozen import Value
from seoro.lang.loader import Sources
from seoro.lang.program import Program, Recorder
from seoro.lang.source import Span
from seoro.lang.symbols import Kind, TypeSymbol

STANDARD_MODULES = ("osc.standard", "osc.standard.all", "osc.standard.types", "osc.standard.domain")


class Checked(Value):
    """Result of a check.

    Args:
        sources: The checked sources.
        diagnostics: All diagnostics, sorted by file and place.
        scenarios: Names of the scenarios in the entry file, in source order.
        program: The declarations.
        behaviors: The behavior of each scenario and action that has one.
        reactions: Reactions of the types.
        coverage: Items of `cover` and `record`.
    """

    sources: Sources
    diagnostics: tuple[Diagnostic, ...]
    scenarios: tuple[str, ...]
    program: Program
    behaviors: Mapping[TypeSymbol, plan.Behavior]
    reactions: Reactions
    coverage: plan.Coverage

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """Diagnostics that prevent a run."""
        return tuple(found for found in self.diagnostics if found.severity is Severity.ERROR)


def check(
    sources: Sources,
    traits: Traits = NO_TRAITS,
    strict: bool = False,
    recorder: Recorder | None = None,
    known: body_cache.BodyMessages | None = None,
) -> Checked:
    """Check a loaded scenario; errors are in the `diagnostics` of the result.

    Names that unreadable text may declare are not reported as unknown.

    Args:
        sources: The result of `load`.
        traits: Traits of parameters in Python implementations of actions and modifiers.
        strict: Whether to warn of extensions to the standard.
        recorder: Receives the meanings of names and the types of values.
        known: Cached messages of an earlier check of the same file.
    """
    bag = Bag()
    program = Program(Span(sources.entry.file, 0, 0), sources.unread, recorder)
    expressions = Expressions(program, bag, strict, traits)
    behaviors = body_cache.ElaboratedBehaviors(expressions)
    reactions = Reactions(expressions)
    if strict:
        _note_reserved(sources, bag)
    _declare_all(sources, program, bag)
    expressions.methods.elaborate_all()
    _check_fields(program, expressions)
    coverage = Coverage(expressions).check()
    reactions.elaborate(program)
    if known is not None:
        known.check(sources, expressions, behaviors)
    else:
        for found in body_cache.bodies(program):
            behaviors.add(found)
    expressions.applications.check(bag)
    diagnostics = in_order(sources, (*sources.diagnostics, *bag.diagnostics))
    return Checked(sources, diagnostics, _scenarios(sources, program), program, behaviors, reactions, coverage)


def in_order(sources: Sources, diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Sort diagnostics by file, the entry file first, and place."""
    order = {module.file.name: number for number, module in enumerate(reversed(sources.modules))}
    return tuple(sorted(diagnostics, key=lambda found: (order.get(found.position[0], -1), *found.position[1:])))


def _declare_all(sources: Sources, program: Program, bag: Bag) -> None:
    """Run the passes over declarations."""
    declared = declare.declare(sources, program, bag)
    declare.declare_units(declared, program, bag)
    declare.declare_behaviors(declared, program, bag)
    declare.check_namespaces(declared, program, bag)
    declare.name_for_plan(program)
    resolver = resolve.Resolver(program, bag)
    resolver.resolve(declared)
    members.Members(program, resolver, bag).declare(declared)
    resolver.resolve_conditions()


def _check_fields(program: Program, expressions: Expressions) -> None:
    """Check the fields and constraints of all types, parameters of events, and global parameters."""
    values, defaults, structured = expressions.values, expressions.defaults, program.structured()
    for symbol in structured:
        values.structure(symbol)
        for event in symbol.events.values():
            for parameter in event.parameters.values():
                defaults.of(parameter)
    values.globals()
    check_containment(program.structures, expressions.bag)
    for symbol in structured:
        defaults.check_order(symbol.inventory.fields)
    defaults.check_order({found.name: found for found in program.globals.values()})


def _note_reserved(sources: Sources, bag: Bag) -> None:
    """Report namespaces of users and libraries with reserved names."""
    for statement in sources.entry.tree.statements:
        match statement:
            case ast.ImportModule(path):
                name = ".".join(path)
                if name.startswith("osc.") and name not in STANDARD_MODULES:
                    bag.add(messages.library_import, statement.span, name)
            case ast.NamespaceStatement(name) if name.startswith(declare.RESERVED_NAMESPACES):
                bag.add(messages.reserved_namespace, statement.span, name)
            case _:
                pass


def _scenarios(sources: Sources, program: Program) -> tuple[str, ...]:
    file = sources.entry.file
    declared = [symbol for symbol in program.behaviors.values() if symbol.span.file is file]
    found = [symbol for symbol in declared if symbol.kind is Kind.SCENARIO]
    return tuple(symbol.plan_name for symbol in sorted(found, key=lambda symbol: symbol.span.start))
