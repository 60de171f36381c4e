"""Makes the plan of a scenario: its parameters with their values, and every scenario and action that it
reaches."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from seoro.errors import InvalidScenario
from seoro.lang import ast, plan
from seoro.lang.check.checker import Checked
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import scope_of
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.lower import reach
from seoro.lang.lower.entry import find_entry
from seoro.lang.lower.invocations import called, constrained, named_invocations
from seoro.lang.lower.overrides import Overrides
from seoro.lang.symbols import TypeSymbol, all_events, all_fields, do_directive, lineage, may_lack_values


def lower_scenario(checked: Checked, scenario: str | None, overrides: Mapping[str, str]) -> plan.Plan:
    """The plan of a scenario; `InvalidScenario` if it has errors, has no entry, or lacks a value."""
    if checked.errors:
        raise InvalidScenario(checked.errors)
    entry = find_entry(checked, scenario)
    lowering = _Lowering(checked)
    first, given = lowering.entry(entry, overrides)
    global_parameters = lowering.globals(entry, overrides)
    lowering.check_values(entry, overrides)
    if len(lowering.bag):
        raise InvalidScenario(lowering.bag.diagnostics)
    scenarios = {first.name: first}
    actions: dict[str, plan.Action] = {}
    pending = [first]
    while pending:
        for invocation in reach.invocations(pending.pop().body):
            if isinstance(invocation, plan.InvokeAction):
                if invocation.action not in actions:
                    actions[invocation.action] = lowering.action(invocation.action)
            elif invocation.scenario not in scenarios:
                scenarios[invocation.scenario] = lowering.invoked(invocation.scenario)
                pending.append(scenarios[invocation.scenario])
    objects = lowering.objects()
    modifiers = lowering.modifiers(scenarios.values(), actions.values(), objects.values())
    structures = checked.program.structures
    structures.modify(modifiers, {name: type_.modifiers for name, type_ in objects.items()})
    return plan.Plan(
        entry=first.name,
        overrides=given,
        scenarios=scenarios,
        actions=actions,
        modifiers=modifiers,
        objects=objects,
        globals=global_parameters,
        structures=structures,
        file=checked.sources.entry.file.name,
        coverage=checked.coverage,
    )


class _Lowering:
    """Makes the parts of one plan."""

    def __init__(self, checked: Checked) -> None:
        self.bag = Bag()
        self._checked = checked
        self._program = checked.program
        self._expressions = Expressions(checked.program, self.bag, strict=False)
        self._symbols = {symbol.plan_name: symbol for symbol in checked.program.behaviors.values()}

    def scenario(self, symbol: TypeSymbol) -> plan.Scenario:
        """A scenario with everything that it inherits."""
        reactions, declared = self._checked.reactions, do_directive(symbol)
        return plan.Scenario(
            name=symbol.plan_name,
            bases=_bases(symbol),
            structure=self._program.structures.of(symbol.plan_type),
            events=self._events(symbol),
            on=reactions.on(symbol),
            samples=reactions.samples(symbol),
            modifiers=reactions.modifiers(symbol),
            body=self._checked.behaviors[declared.owner] if declared is not None else None,
            span=symbol.span,
        )

    def invoked(self, name: str) -> plan.Scenario:
        """A scenario by its name."""
        return self.scenario(self._symbols[name])

    def action(self, name: str) -> plan.Action:
        """The declaration of an action."""
        symbol, reactions = self._symbols[name], self._checked.reactions
        return plan.Action(
            name=name,
            bases=_bases(symbol),
            actor=_actor(symbol),
            structure=self._program.structures.of(symbol.plan_type),
            events=self._events(symbol),
            on=reactions.on(symbol),
            samples=reactions.samples(symbol),
            modifiers=reactions.modifiers(symbol),
            library=symbol.home.library,
            span=symbol.span,
        )

    def modifiers(
        self,
        scenarios: Iterable[plan.Scenario],
        actions: Iterable[plan.Action],
        objects: Iterable[plan.ObjectType],
    ) -> dict[str, plan.Modifier]:
        """All modifiers that are applied in a plan."""
        symbols = {symbol.plan_name: symbol for symbol in self._program.modifiers.values()}
        pending = [name for scenario in scenarios for name in reach.modifiers(scenario.body)]
        pending += [name for scenario in scenarios for name in reach.applied(scenario)]
        pending += [name for action in actions for name in reach.applied(action)]
        pending += [name for type_ in objects for name in reach.applied(type_)]
        found: dict[str, plan.Modifier] = {}
        while pending:
            name = pending.pop(0)
            if name not in found:
                found[name] = self._modifier(symbols[name])
                pending += reach.applied(found[name])
        return found

    def _modifier(self, symbol: TypeSymbol) -> plan.Modifier:
        reactions = self._checked.reactions
        return plan.Modifier(
            name=symbol.plan_name,
            actor=_actor(symbol),
            of=symbol.of.plan_name if symbol.of is not None else None,
            structure=self._program.structures.of(symbol.plan_type),
            events=self._events(symbol),
            on=reactions.on(symbol),
            samples=reactions.samples(symbol),
            modifiers=reactions.modifiers(symbol),
            library=symbol.home.library if _is_atomic(symbol) else None,
            span=symbol.span,
        )

    def objects(self) -> dict[str, plan.ObjectType]:
        """The structs and actors that have events, sampled variables or modifiers."""
        found: dict[str, plan.ObjectType] = {}
        for symbol in self._program.types.values():
            if isinstance(symbol, TypeSymbol):
                reactions = self._checked.reactions
                has = self._events(symbol), reactions.samples(symbol), reactions.modifiers(symbol)
                if any(has):
                    found[symbol.plan_name] = plan.ObjectType(symbol.plan_name, *has, symbol.span)
        return found

    def _events(self, symbol: TypeSymbol) -> tuple[plan.Event, ...]:
        reactions = self._checked.reactions
        return tuple(
            plan.Event(event.name, reactions.parameters(event), reactions.specification(event), event.span)
            for event in all_events(symbol).values()
        )

    def globals(self, entry: TypeSymbol, overrides: Mapping[str, str]) -> plan.Structure:
        """The global parameters; those that nothing can give a value are reported."""
        for declaration, home in self._program.global_declarations:
            may_be_constrained = declaration.constraints or may_lack_values(entry)
            for name in declaration.names if not may_be_constrained else ():
                symbol = self._program.globals[home.namespace_of(name), name.text]
                lacking = self._expressions.values.lacking(symbol)
                if any(not _is_set(path.rpartition("::")[2], overrides) for path in lacking):
                    self.bag.add(messages.GlobalWithoutValue(symbol.span, symbol.text))
        return self._expressions.values.globals()

    def entry(
        self, symbol: TypeSymbol, overrides: Mapping[str, str]
    ) -> tuple[plan.Scenario, tuple[plan.Constraint, ...]]:
        """The entry scenario, and what is set from outside for its parameters and for global ones."""
        scenario = self.scenario(symbol)
        named = named_invocations(scenario.body)
        invoked = {name: self._symbols[called(each)] for name, each in named.items()}
        given = Overrides(self._expressions, scope_of(symbol, symbol.home), self.bag, invoked).constraints(
            overrides
        )
        added = {named[name]: constraints for name, constraints in given.of_invocations.items()}
        if scenario.body is not None and added:
            scenario = replace(scenario, body=constrained(scenario.body, added))
        return scenario, given.own

    def check_values(self, symbol: TypeSymbol, overrides: Mapping[str, str]) -> None:
        """Report fields of the entry scenario that nothing gives a value."""
        values = self._expressions.values
        fields = all_fields(symbol)
        for path in values.lacking_of(symbol, {}):
            if not _is_set(path, overrides):
                self.bag.add(messages.NoValue(fields[path.partition(".")[0]].span, path))


def _is_set(path: str, overrides: Mapping[str, str]) -> bool:
    """Whether a field, or what holds it, is set from outside."""
    return any(path == given or path.startswith(f"{given}.") for given in overrides)


def _bases(symbol: TypeSymbol) -> tuple[str, ...]:
    """The names of what a type inherits, nearest first."""
    return tuple(base.plan_name for base in lineage(symbol))[1:]


def _actor(symbol: TypeSymbol) -> plan.ActorType | None:
    """The type of actor that something belongs to."""
    actor = symbol.actor.plan_type if symbol.actor is not None else None
    assert actor is None or isinstance(actor, plan.ActorType)
    return actor


def _is_atomic(symbol: TypeSymbol) -> bool:
    """Whether a modifier says no more than its parameters: in a library, its implementation is then elsewhere."""
    return all(isinstance(member, ast.ParameterDeclaration) for part in symbol.parts for member in part.members)
