"""Creation of the plan of a scenario: its parameters with their values, and all reached scenarios and actions.

The scenario (7.7.2) is the requested one, the only one, or `main` of the entry file.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import replace
from typing import Final, NamedTuple

from seoro.errors import InvalidScenario
from seoro.lang import ast, plan
from seoro.lang.check.checker import Checked
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.plan_types import plan_type
from seoro.lang.check.scopes import scope_of
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.lower.invocations import (
    Invocation,
    applied,
    applied_in,
    constrained,
    invoked_name,
    named_invocations,
)
from seoro.lang.lower.outside import outside_constraints
from seoro.lang.lower.overrides import Overrides
from seoro.lang.source import Span
from seoro.lang.symbols import TypeSymbol, lineage, may_lack_values

DEFAULT = "main"


def find_entry(checked: Checked, name: str | None) -> TypeSymbol:
    """Return the scenario to run.

    Raises:
        InvalidScenario: The scenario is missing or ambiguous.
    """
    file = checked.sources.entry.file
    top = Span(file, 0, 0)
    candidates = checked.scenarios
    if name is not None:
        named = _named(name, candidates)
        if len(named) != 1:
            missing = messages.unknown_entry(top, name, candidates)
            raise InvalidScenario((messages.ambiguous_entry(top, named) if named else missing,))
        chosen = named[0]
    elif not candidates:
        raise InvalidScenario((messages.missing_scenario(top),))
    elif len(candidates) == 1:
        chosen = candidates[0]
    elif len(named := _named(DEFAULT, candidates)) == 1:
        chosen = named[0]
    else:
        raise InvalidScenario((messages.ambiguous_entry(top, candidates),))
    symbol = next(
        symbol
        for symbol in checked.program.behaviors.values()
        if symbol.plan_name == chosen and symbol.span.file is file
    )
    if symbol.actor is not None:
        raise InvalidScenario((messages.actor_entry(symbol.span, chosen),))
    return symbol


def _named(name: str, candidates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the scenario with exactly this name, else those with it in any namespace."""
    if name in candidates:
        return (name,)
    return tuple(candidate for candidate in candidates if candidate.endswith(f"::{name}"))


_NO_OVERRIDES: Final[Mapping[str, str]] = {}


def lower(
    checked: Checked,
    scenario: str | None = None,
    overrides: Mapping[str, str] = _NO_OVERRIDES,
    constraints: Sequence[str] = (),
) -> plan.Plan:
    """Create the plan of a scenario; for many plans of one scenario, see `Plans`.

    Args:
        checked: The result of `check`.
        scenario: The scenario to run; by default the only one of the file, or the one named `main`.
        overrides: As of `Plans.with_overrides`.
        constraints: As of `Plans.with_overrides`.

    Raises:
        InvalidScenario: The sources have errors, no scenario to run, or a parameter without a value.
    """
    return Plans(checked, scenario).with_overrides(overrides, constraints)


class Plans:
    """Plans of one scenario with different overrides; all but these is created once.

    Args:
        checked: The result of `check`.
        scenario: The scenario to run; by default the only one of the file, or the one named `main`.

    Raises:
        InvalidScenario: The sources have errors, or no scenario to run.
    """

    def __init__(self, checked: Checked, scenario: str | None = None) -> None:
        if checked.errors:
            raise InvalidScenario(checked.errors)
        self._entry = find_entry(checked, scenario)
        self._lowering = _Lowering(checked)
        self._named: Mapping[str, Invocation] = {}
        self._shared: plan.Plan | None = None  # without overrides

    @property
    def draft(self) -> plan.Plan:
        """The plan without overrides, in which parameters may lack values."""
        return self._shared or self._create()

    def missing_values(self) -> tuple[str, ...]:
        """Return the paths of parameters of the scenario that need a value from outside."""
        return self._lowering.missing_values(self._entry)

    def with_overrides(
        self, overrides: Mapping[str, str] = _NO_OVERRIDES, constraints: Sequence[str] = ()
    ) -> plan.Plan:
        """Create a plan.

        Args:
            overrides: Values for parameters of the scenario, or for fields of them (`robot.namespace`), as
                expressions of the language.
            constraints: Further constraints on them, as boolean expressions: `pace in [2mps..3mps]`.

        Raises:
            InvalidScenario: An override is invalid, or a parameter has no value.
        """
        bag = Bag()
        shared = self._shared or self._create()
        outside = self._lowering.outside(self._entry, self._named, overrides, constraints, bag)
        self._lowering.check_globals(self._entry, outside.paths, bag)
        self._lowering.check_values(self._entry, outside.paths, bag)
        if len(bag):
            raise InvalidScenario(bag.diagnostics)
        self._shared = shared
        if not overrides and not constraints:
            return shared
        first = shared.scenarios[shared.entry]
        if first.body is not None and outside.of_invocations:
            first = replace(first, body=constrained(first.body, outside.of_invocations))
        return replace(shared, overrides=outside.own, scenarios={**shared.scenarios, first.name: first})

    def _create(self) -> plan.Plan:
        """Create the plan without overrides."""
        first = self._lowering.scenario(self._entry)
        self._named = named_invocations(first.body)
        return self._lowering.reached_from(first)


class _Outside(NamedTuple):
    """Constraints from outside: on the entry scenario, on its invocations, and the paths of their parameters."""

    own: tuple[plan.Constraint, ...]
    of_invocations: Mapping[Invocation, Sequence[plan.Constraint]]
    paths: Set[str]


class _Lowering:
    """Creates the parts of one plan."""

    def __init__(self, checked: Checked) -> None:
        self._checked = checked
        self._program = checked.program
        self._expressions = Expressions(checked.program, Bag(), strict=False)
        self._symbols = {symbol.plan_name: symbol for symbol in checked.program.behaviors.values()}

    def scenario(self, symbol: TypeSymbol) -> plan.Scenario:
        """Create a scenario with all inherited members."""
        declared = symbol.do
        return plan.Scenario(
            *self._common(symbol),
            bases=_bases(symbol),
            body=self._checked.behaviors[declared.owner] if declared is not None else None,
        )

    def _common(
        self, symbol: TypeSymbol
    ) -> tuple[
        str,
        plan.Structure,
        tuple[plan.Event, ...],
        tuple[plan.On, ...],
        tuple[plan.Sample, ...],
        tuple[plan.AppliedModifier, ...],
        Span,
    ]:
        """Return the fields of `plan.Declaration`."""
        structure, reactions = self._program.structures.of(symbol.plan_type), self._checked.reactions
        own = reactions.on(symbol), reactions.samples(symbol), reactions.modifiers(symbol)
        return symbol.plan_name, structure, self._events(symbol), *own, symbol.span

    def invoked(self, name: str) -> plan.Scenario:
        """Create a scenario by its name."""
        return self.scenario(self._symbols[name])

    def action(self, name: str) -> plan.Action:
        """Create the declaration of an action."""
        symbol = self._symbols[name]
        return plan.Action(
            *self._common(symbol),
            bases=_bases(symbol),
            actor=_actor(symbol),
            library=symbol.home.library,
        )

    def modifiers(
        self,
        scenarios: Iterable[plan.Scenario],
        actions: Iterable[plan.Action],
        objects: Iterable[plan.ObjectType],
    ) -> dict[str, plan.Modifier]:
        """Create all modifiers that are applied in a plan."""
        symbols = {symbol.plan_name: symbol for symbol in self._program.modifiers.values()}
        pending = [name for scenario in scenarios for name in applied_in(scenario.body)]
        declared: list[plan.Declaration | plan.ObjectType] = [*scenarios, *actions, *objects]
        pending += [name for each in declared for name in applied(each.modifiers)]
        found: dict[str, plan.Modifier] = {}
        while pending:
            name = pending.pop(0)
            if name not in found:
                found[name] = self._modifier(symbols[name])
                pending += applied(found[name].modifiers)
        return found

    def _modifier(self, symbol: TypeSymbol) -> plan.Modifier:
        return plan.Modifier(
            *self._common(symbol),
            actor=_actor(symbol),
            of=symbol.of.plan_name if symbol.of is not None else None,
            library=symbol.home.library if _is_atomic(symbol) else None,
        )

    def objects(self) -> dict[str, plan.ObjectType]:
        """Create the structs and actors with events, sampled variables or modifiers."""
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
            plan.Event(
                event.name,
                reactions.parameters[event],
                tuple(plan_type(each.type, self._program) for each in event.parameters.values()),
                reactions.specifications.get(event),
                event.span,
            )
            for event in symbol.inventory.events.values()
        )

    def reached_from(self, first: plan.Scenario) -> plan.Plan:
        """Create the plan of an entry scenario, with all that it reaches, without overrides."""
        scenarios = {first.name: first}
        actions: dict[str, plan.Action] = {}
        pending = [first]
        while pending:
            for invocation in plan.invocations_in(pending.pop().body):
                if isinstance(invocation, plan.InvokeAction):
                    if invocation.action not in actions:
                        actions[invocation.action] = self.action(invocation.action)
                elif invocation.scenario not in scenarios:
                    scenarios[invocation.scenario] = self.invoked(invocation.scenario)
                    pending.append(scenarios[invocation.scenario])
        objects = self.objects()
        return plan.Plan(
            entry=first.name,
            overrides=(),
            scenarios=scenarios,
            actions=actions,
            modifiers=self.modifiers(scenarios.values(), actions.values(), objects.values()),
            objects=objects,
            globals=self._expressions.values.globals(),
            structures=self._program.structures,
            methods=self._program.methods,
            file=self._checked.sources.entry.file.name,
            coverage=self._checked.coverage,
        )

    def outside(
        self,
        entry: TypeSymbol,
        named: Mapping[str, Invocation],
        overrides: Mapping[str, str],
        constraints: Sequence[str],
        bag: Bag,
    ) -> _Outside:
        """Create the constraints from outside; report invalid ones.

        Args:
            entry: The entry scenario.
            named: Its invocations by name.
            overrides: Values by path.
            constraints: Further constraints.
            bag: Bag for messages.
        """
        invoked = {name: self._symbols[invoked_name(each)] for name, each in named.items()}
        expressions, scope = Expressions(self._program, bag, strict=False), scope_of(entry, entry.home)
        given = Overrides(expressions, scope, bag, invoked).constraints(overrides)
        outside = outside_constraints(constraints, expressions, scope, bag, invoked)
        added: defaultdict[Invocation, list[plan.Constraint]] = defaultdict(list)
        for name, found in given.of_invocations.items():
            added[named[name]] += found
        for each in outside:
            if each.invocation:
                added[named[each.invocation]].append(each.constraint)
        own = [each for each in outside if not each.invocation]
        paths = {*overrides, *(path.rpartition("::")[2] for each in own for path in each.paths)}
        return _Outside((*given.own, *(each.constraint for each in own)), added, paths)

    def check_globals(self, entry: TypeSymbol, bounded: Set[str], bag: Bag) -> None:
        """Report global parameters without a value and without a constraint from outside."""
        for declaration, home in self._program.global_declarations:
            may_be_constrained = declaration.constraints or may_lack_values(entry)
            for name in declaration.names if not may_be_constrained else ():
                symbol = self._program.globals[home.namespace_of(name), name.text]
                lacking = self._expressions.values.lacking(symbol)
                if any(not _is_set(path.rpartition("::")[2], bounded) for path in lacking):
                    bag.add(messages.global_without_value, symbol.span, symbol.text)

    def missing_values(self, entry: TypeSymbol) -> tuple[str, ...]:
        """Return the paths of fields of the entry scenario without a value."""
        return self._expressions.values.lacking_of(entry, {})

    def check_values(self, entry: TypeSymbol, bounded: Set[str], bag: Bag) -> None:
        """Report fields of the entry scenario without a value and without a constraint from outside."""
        fields = entry.inventory.fields
        for path in self.missing_values(entry):
            if not _is_set(path, bounded):
                bag.add(messages.missing_value, fields[path.partition(".")[0]].span, path)


def _is_set(path: str, bounded: Set[str]) -> bool:
    """Return whether constraints from outside concern a field or a value that contains it."""
    return any(path == given or path.startswith(f"{given}.") for given in bounded)


def _bases(symbol: TypeSymbol) -> tuple[str, ...]:
    """Return the names of the bases of a type, nearest first."""
    return tuple(base.plan_name for base in lineage(symbol))[1:]


def _actor(symbol: TypeSymbol) -> plan.ActorType | None:
    """Return the actor type of a scenario, an action or a modifier."""
    actor = symbol.actor.plan_type if symbol.actor is not None else None
    assert actor is None or isinstance(actor, plan.ActorType)
    return actor


def _is_atomic(symbol: TypeSymbol) -> bool:
    """Return whether a modifier declares only parameters, so that a library implements it in Python."""
    return all(isinstance(member, ast.ParameterDeclaration) for part in symbol.parts for member in part.members)
