"""Fifth pass, first half: what types do by themselves: derived events, `on` directives (7.3.10), sampled variables
(7.3.6.1.2), and the modifiers that are members of them (7.3.12.4)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from seoro.lang import ast, plan
from seoro.lang.check.compositions import parameters_of_invocation
from seoro.lang.check.declare import describe_kind
from seoro.lang.check.directives import Directives
from seoro.lang.check.events import Events
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.labels import Labels
from seoro.lang.check.modifiers import Modified, Modifiers, own_actor
from seoro.lang.check.scopes import running_scope
from seoro.lang.check.values import declared
from seoro.lang.diagnostics import names
from seoro.lang.symbols import EventSymbol, Kind, Program, TypeSymbol, all_events, has_phases, lineage


class Reactions:
    """What the types of a program do by themselves, by the types that declare it.

    Args:
        expressions: For conditions and arguments.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._specifications: dict[EventSymbol, plan.EventSpecification] = {}
        self._parameters: dict[EventSymbol, tuple[tuple[str, plan.Expression | None], ...]] = {}
        self._on: dict[TypeSymbol, list[plan.On]] = {}
        self._samples: dict[TypeSymbol, list[plan.Sample]] = {}
        self._modifiers: dict[TypeSymbol, list[plan.AppliedModifier]] = {}

    def elaborate(self, program: Program) -> None:
        """Elaborate those of all types."""
        structured = program.structured()
        for symbol in structured:
            labels = Labels(symbol, self._expressions)
            for event in symbol.events.values():
                default = self._expressions.values.default
                self._parameters[event] = tuple((each.name, default(each)) for each in event.parameters.values())
                if event.specification is not None and not event.parameters:
                    scope = running_scope(symbol, event.home, labels)
                    found = Events(self._expressions, scope).specification(event.specification)
                    if found is not None:
                        self._specifications[event] = found
            self._elaborate_members(symbol, labels)
        for symbol in structured:
            self._check_events(symbol)
        self._check_modifiers(program)

    def specification(self, event: EventSymbol) -> plan.EventSpecification | None:
        """What makes an event occur besides being emitted."""
        return self._specifications.get(event)

    def parameters(self, event: EventSymbol) -> tuple[tuple[str, plan.Expression | None], ...]:
        """The parameters of an event, with their defaults."""
        return self._parameters[event]

    def on(self, symbol: TypeSymbol) -> tuple[plan.On, ...]:
        """The `on` directives of a type, inherited ones first."""
        return tuple(found for type_ in reversed(list(lineage(symbol))) for found in self._on[type_])

    def samples(self, symbol: TypeSymbol) -> tuple[plan.Sample, ...]:
        """The variables of a type that are sampled, inherited ones first."""
        return tuple(found for type_ in reversed(list(lineage(symbol))) for found in self._samples[type_])

    def modifiers(self, symbol: TypeSymbol) -> tuple[plan.AppliedModifier, ...]:
        """The modifiers that are members of a type, inherited ones first."""
        return tuple(found for type_ in reversed(list(lineage(symbol))) for found in self._modifiers[type_])

    def _elaborate_members(self, symbol: TypeSymbol, labels: Labels) -> None:
        """The `on` directives and modifiers of a type itself and of its extensions."""
        on = self._on[symbol] = []
        samples = self._samples[symbol] = []
        applied = self._modifiers[symbol] = []
        modified = _modified(symbol)
        for part in symbol.parts:
            scope = running_scope(symbol, part.home, labels)
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
        """The variables of one declaration that are sampled, each with what it is set to, and when."""
        node = declaration.value
        if not isinstance(node, ast.SampleExpression):
            return
        event, scope = events.specified(node.event)
        for field in declared(symbol, declaration.names):
            value = self._expressions.converted(node.value, field.type, scope, f"`{field.text}`")
            if event is not None:
                yield plan.Sample(field.name, value, event, node.span)

    # ------------------------------------------------------------ circles

    def _check_events(self, symbol: TypeSymbol) -> None:
        """Report derived events of a type that wait for each other."""
        declared = all_events(symbol)
        for circle in _circles({name: self._derived_from(event) for name, event in declared.items()}):
            own = next((symbol.events[name] for name in circle if name in symbol.events), None)
            if own is not None:  # else it is reported with the base
                self._expressions.bag.add(names.CyclicReference(own.span, "events", circle))

    def _derived_from(self, event: EventSymbol) -> tuple[str, ...]:
        """The event of the same instance from which an event is derived, if there is one."""
        match self._specifications.get(event):
            case plan.OnEvent(plan.DeclaredEvent(name)):
                return (name,)
            case _:
                return ()

    def _check_modifiers(self, program: Program) -> None:
        """Report modifiers that apply each other."""
        symbols = {symbol.plan_name: symbol for symbol in program.modifiers.values()}
        applied = {name: self._applied(symbol) for name, symbol in symbols.items()}
        for circle in _circles(applied):
            self._expressions.bag.add(names.CyclicReference(symbols[circle[0]].span, "modifiers", circle))

    def _applied(self, symbol: TypeSymbol) -> tuple[str, ...]:
        found = self._modifiers[symbol]
        return tuple(each.modifier for each in found if isinstance(each, plan.ModifierApplication))


def _modified(symbol: TypeSymbol) -> Modified:
    """What modifiers that are members of a type modify."""
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


def _circles(edges: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, ...]]:
    """Circles of names, each of which leads to the next; one for each part of the graph that has some."""
    done: set[str] = set()
    for first in edges:
        path = {first: iter(edges[first])} if first not in done else {}
        while path:
            following = next((name for name in path[next(reversed(path))] if name not in done), None)
            if following is None:
                done.add(path.popitem()[0])
            elif following in path:
                order = list(path)
                yield (*order[order.index(following) :], following)
                done.update(path)
                break
            else:
                path[following] = iter(edges[following])
