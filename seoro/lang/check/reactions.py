"""Fifth pass, first half: reactions of types.

These are derived events, `on` directives (7.3.10), sampled variables (7.3.6.1.2), and modifiers that are members
(7.3.12.4).
"""

from __future__ import annotations

from collections.abc import Iterator

from seoro.lang import ast, plan
from seoro.lang.check.behaviors import Directives
from seoro.lang.check.declare import describe_kind
from seoro.lang.check.events import Events
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.modifiers import Modified, Modifiers, own_actor
from seoro.lang.check.scopes import parameters_of_invocation, running_scope
from seoro.lang.check.traversal import circles
from seoro.lang.check.values import declared
from seoro.lang.diagnostics import names
from seoro.lang.program import Program
from seoro.lang.symbols import EventSymbol, Kind, TypeSymbol, has_phases, lineage


class Reactions:
    """Reactions of the types of a program, by the declaring type.

    Args:
        expressions: The expression checker.

    Attributes:
        specifications: Specifications that make events occur without `emit`.
        parameters: Parameters of events, with their defaults.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self.specifications: dict[EventSymbol, plan.EventSpecification] = {}
        self.parameters: dict[EventSymbol, tuple[tuple[str, plan.Expression | None], ...]] = {}
        self._on: dict[TypeSymbol, list[plan.On]] = {}
        self._samples: dict[TypeSymbol, list[plan.Sample]] = {}
        self._modifiers: dict[TypeSymbol, list[plan.AppliedModifier]] = {}

    def elaborate(self, program: Program) -> None:
        """Elaborate the reactions of all types."""
        structured = program.structured()
        for symbol in structured:
            for event in symbol.events.values():
                default = self._expressions.defaults.of
                self.parameters[event] = tuple((each.name, default(each)) for each in event.parameters.values())
                if event.specification is not None and not event.parameters:
                    scope = running_scope(symbol, event.home)
                    found = Events(self._expressions, scope).specification(event.specification)
                    if found is not None:
                        self.specifications[event] = found
            self._elaborate_members(symbol)
        for symbol in structured:
            self._check_events(symbol)
        self._check_modifiers(program)

    def on(self, symbol: TypeSymbol) -> tuple[plan.On, ...]:
        """Return the `on` directives of a type, inherited ones first."""
        return tuple(found for type_ in reversed(list(lineage(symbol))) for found in self._on[type_])

    def samples(self, symbol: TypeSymbol) -> tuple[plan.Sample, ...]:
        """Return the sampled variables of a type, inherited ones first."""
        return tuple(found for type_ in reversed(list(lineage(symbol))) for found in self._samples[type_])

    def modifiers(self, symbol: TypeSymbol) -> tuple[plan.AppliedModifier, ...]:
        """Return the modifiers among the members of a type, inherited ones first."""
        return tuple(found for type_ in reversed(list(lineage(symbol))) for found in self._modifiers[type_])

    def _elaborate_members(self, symbol: TypeSymbol) -> None:
        """Elaborate the `on` directives and modifiers of a type itself and of its extensions."""
        on = self._on[symbol] = []
        samples = self._samples[symbol] = []
        applied = self._modifiers[symbol] = []
        modified = _modified(symbol)
        for part in symbol.parts:
            scope = running_scope(symbol, part.home)
            for member in part.members:
                if isinstance(member, ast.OnDirective) and has_phases(symbol):
                    events = Events(self._expressions, scope)
                    directive = Directives(self._expressions, events).on(member)
                    on += [directive] if directive is not None else []
                elif isinstance(member, ast.VariableDeclaration):
                    events = Events(self._expressions, scope)
                    samples += self._sampled(symbol, member, events)
                elif isinstance(member, ast.ModifierApplication):
                    modifiers = Modifiers(self._expressions, scope)
                    application = modifiers.apply(member, modified)
                    applied += [application] if application is not None else []

    def _sampled(
        self, symbol: TypeSymbol, declaration: ast.VariableDeclaration, events: Events
    ) -> Iterator[plan.Sample]:
        """Yield the sampled variables of one declaration, each with its value and event."""
        node = declaration.value
        if not isinstance(node, ast.SampleExpression):
            return
        event, scope = events.specified(node.event)
        for field in declared(symbol, declaration.names):
            value = self._expressions.converted(node.value, field.type, scope, f"`{field.text}`")
            if event is not None:
                yield plan.Sample(field.name, value, event, node.span)

    # ------------------------------------------------------------ cycles

    def _check_events(self, symbol: TypeSymbol) -> None:
        """Report derived events of a type that form a cycle."""
        declared = symbol.inventory.events
        for circle in circles({name: self._derived_from(event) for name, event in declared.items()}):
            own = next((symbol.events[name] for name in circle if name in symbol.events), None)
            if own is not None:  # else it is reported with the base
                self._expressions.bag.add(names.cyclic_reference, own.span, "events", circle)

    def _derived_from(self, event: EventSymbol) -> tuple[str, ...]:
        """Return the event of the same instance from which an event is derived, if any."""
        match self.specifications.get(event):
            case plan.OnEvent(plan.DeclaredEvent(name)):
                return (name,)
            case _:
                return ()

    def _check_modifiers(self, program: Program) -> None:
        """Report modifiers that apply each other."""
        symbols = {symbol.plan_name: symbol for symbol in program.modifiers.values()}
        applied = {name: self._applied(symbol) for name, symbol in symbols.items()}
        for circle in circles(applied):
            self._expressions.bag.add(names.cyclic_reference, symbols[circle[0]].span, "modifiers", circle)

    def _applied(self, symbol: TypeSymbol) -> tuple[str, ...]:
        found = self._modifiers[symbol]
        return tuple(each.modifier for each in found if isinstance(each, plan.ModifierApplication))


def _modified(symbol: TypeSymbol) -> Modified:
    """Return the behavior that members of a type modify."""
    actors = own_actor(symbol)
    match symbol.kind:
        case Kind.SCENARIO | Kind.ACTION:
            return Modified(symbol, f"`{symbol.qualified_name}`", actors, parameters_of_invocation(symbol))
        case Kind.STRUCT | Kind.ACTOR:
            return Modified(None, describe_kind(symbol), actors, frozenset())
        case Kind.MODIFIER:
            what = (
                f"a modifier of `{symbol.of.qualified_name}`"
                if symbol.of is not None
                else "a modifier of anything"
            )
            parameters = parameters_of_invocation(symbol.of) if symbol.of is not None else frozenset()
            return Modified(symbol.of, None if symbol.is_open else what, actors, parameters)
