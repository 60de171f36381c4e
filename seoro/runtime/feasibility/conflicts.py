"""Invocations with arguments that contradict the constraints of the invoked declaration, found without a run.

An invocation is relaxed to parameters and constraints with values fixed by the text. Constraints with other
inputs, and defaults that these may override, are dropped. If the rest is contradictory, no run can carry out the
invocation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from contextlib import suppress
from dataclasses import replace
from typing import TypeAlias

from seoro.errors import CONFLICT
from seoro.lang import plan as plan_
from seoro.lang.plan import InvokeAction, InvokeScenario, Plan, Scenario, invocations_in
from seoro.runtime.behaviors.timing import times_of
from seoro.runtime.choose.slots import domain_of
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Instance
from seoro.runtime.instances.times import DURATION, Times
from seoro.runtime.parameters.parameters import Invocation, choose_parameters
from seoro.runtime.values.environment import Environment, EvaluationError, NoSolution, Seed
from seoro.runtime.values.values import Fields, Value

_OPEN = (
    plan_.Binding,
    plan_.Call,
    plan_.Global,
    plan_.Labelled,
    plan_.Reference,
    plan_.Self,
)  # values that the text does not fix


def is_fixed(expression: plan_.Expression, names: Set[str], structures: plan_.Structures) -> bool:
    """Whether the text and the named fields determine the value of an expression."""
    for each in plan_.walk(expression):
        if isinstance(each, _OPEN) or (isinstance(each, plan_.Field) and each.name not in names):
            return False
        if isinstance(each, plan_.Construct):
            structure = structures.of(each.type)
            if not structure.is_plain or not structure.open_fields <= {name for name, _ in each.arguments}:
                return False
    return True


def fixed_values(expressions: Iterable[tuple[str, plan_.Expression]], around: Environment) -> dict[str, Value]:
    """Return the values of the fixed expressions.

    Args:
        expressions: Expressions by name.
        around: Environment of their scope; its instance has the fixed fields.
    """
    found: dict[str, Value] = {}
    for name, expression in expressions:
        if is_fixed(expression, around.instance.fields.keys(), around.plan.structures):
            with suppress(EvaluationError):  # the run reports it
                found[name] = evaluate(expression, around)
    return found


def scope_of(
    declared: Scenario,
    given: Mapping[str, Value],
    passed: Set[str],
    limits: tuple[plan_.ConstraintMember, ...],
    plan: Plan,
) -> Environment:
    """Return the environment of a scenario with its fixed parameters: given ones, and uncontested defaults.

    Args:
        declared: The scenario.
        given: Fixed values of arguments.
        passed: Names of all parameters that may differ from their defaults.
        limits: Constraints of the invocation.
        plan: The plan.
    """
    fields = Fields(given)
    around = Environment(Instance(declared.name, fields, declared, {}), plan)
    contested = passed | {name for each in (*declared.structure.members, *limits) for name in _read(each)}
    for field in declared.structure.fields.values():
        if field.default is not None and not field.is_variable and field.name not in contested:
            fields.update(fixed_values([(field.name, field.default)], around))
    return around


def _read(member: plan_.StructureMember) -> Iterator[str]:
    """Yield the names of fields that a constraint may concern."""
    if isinstance(member, plan_.FieldDeclaration):
        return
    for each in plan_.walk(member.parameter if isinstance(member, plan_.RemoveDefault) else member.condition):
        if isinstance(each, plan_.Field) or (
            isinstance(each, plan_.Member) and isinstance(each.base, plan_.Binding | plan_.Self)
        ):
            yield each.name


class Relaxation:
    """Parameters and constraints of an invocation that the text fixes.

    Args:
        structure: Structure of the invoked declaration.
        given: Fixed values of arguments.
        passed: Names of all parameters that may differ from their defaults.
        limits: Constraints of the invocation.
        around: Environment of the invoking scenario, with its fixed fields.
    """

    def __init__(
        self,
        structure: plan_.Structure,
        given: Mapping[str, Value],
        passed: Set[str],
        limits: tuple[plan_.ConstraintMember, ...],
        around: Environment,
    ) -> None:
        self._given, self._known, self._plan = given, around.instance.fields, around.plan
        members = [each for each in structure.members if not isinstance(each, plan_.FieldDeclaration)]
        self._free: set[str] = set(passed - given.keys())
        self._fields = structure.fields
        self._settle((*members, *limits))
        kept = tuple(each for each in members if self._holds(each, is_inside=True))
        fields = tuple(self._relaxed(each) for each in self._fields.values())
        self.structure = replace(
            structure,
            fields={each.name: each for each in fields},
            members=(*fields, *kept),
            open_fields=frozenset(),
        )
        self.limits = tuple(each for each in limits if self._holds(each, is_inside=False))

    @property
    def is_bound(self) -> bool:
        """Whether any constraint remains."""
        return bool(self.limits) or not self.structure.is_plain

    def _settle(self, members: Iterable[plan_.ConstraintMember]) -> None:
        """Drop fields without fixed values, and fields that dropped constraints may change."""
        before = -1
        while len(self._free) > before:
            before = len(self._free)
            self._fields = {name: each for name, each in self._fields.items() if self._is_kept(each)}
            for each in members:
                if not (self._is_readable(each, is_inside=True) or self._is_readable(each, is_inside=False)):
                    self._free |= set(_read(each))

    def _is_kept(self, field: plan_.FieldDeclaration) -> bool:
        """Whether a field is kept: it has a fixed value, or is a parameter with a value to choose."""
        if field.name in self._given:
            return True
        if field.is_variable or domain_of(field.type) is not None:
            return not field.is_variable
        return field.default is None and field.name not in self._free and not self._plan.globals.fields

    def _holds(self, member: plan_.ConstraintMember, *, is_inside: bool) -> bool:
        if isinstance(member, plan_.Constraint) and member.is_default and not self._free.isdisjoint(_read(member)):
            return False
        return self._is_readable(member, is_inside=is_inside)

    def _is_readable(self, member: plan_.ConstraintMember, *, is_inside: bool) -> bool:
        """Whether a constraint reads kept fields only.

        Args:
            member: The constraint.
            is_inside: Whether it belongs to the invoked declaration instead of the invocation.
        """
        expression = member.parameter if isinstance(member, plan_.RemoveDefault) else member.condition
        own = {*self._fields, DURATION}
        pending = [expression]
        while pending:
            each = pending.pop()
            match each:
                case plan_.Member(plan_.Binding("it"), name) if not is_inside and name in own:
                    continue
                case plan_.Field(name) if name not in (self._fields if is_inside else self._known):
                    return False
                case plan_.Construct():
                    return False
                case _ if isinstance(each, _OPEN):
                    return False
            pending += plan_.parts(each)
        return True

    def _relaxed(self, field: plan_.FieldDeclaration) -> plan_.FieldDeclaration:
        """Return a field without a default that may be overridden."""
        default = field.default
        if default is None or field.name in self._given:
            return field
        if field.name in self._free or not is_fixed(default, self._fields.keys(), self._plan.structures):
            return replace(field, default=None)
        return field


_MAX_DEPTH = 50  # of nested invocations with different arguments


Invocations: TypeAlias = Callable[[plan_.Behavior | None], Iterator[InvokeAction | InvokeScenario]]
"""Returns the examined invocations in a behavior."""


def find_conflicts(plan: Plan) -> Iterator[NoSolution]:
    """Yield the conflicts of all reachable invocations, for values that the text fixes."""
    entry = plan.scenarios[plan.entry]
    passed = frozenset(entry.structure.fields if plan.overrides or entry.modifiers else ())
    yield from _conflicts(entry, scope_of(entry, {}, passed, (), plan), 0, set(), invocations_in)


def find_certain_conflicts(plan: Plan, fixed: Mapping[str, Value]) -> Iterator[NoSolution]:
    """Yield the conflicts of invocations that a run cannot avoid; members of `one_of` are left out.

    Args:
        plan: The plan.
        fixed: Values of parameters of the entry scenario; the others may have any value.
    """
    entry = plan.scenarios[plan.entry]
    around = scope_of(entry, fixed, entry.structure.fields.keys() - fixed.keys(), (), plan)
    yield from _conflicts(entry, around, 0, set(), _certain_invocations)


def _certain_invocations(body: plan_.Behavior | None) -> Iterator[InvokeAction | InvokeScenario]:
    match body:
        case InvokeAction() | InvokeScenario():
            yield body
        case plan_.OneOf():
            pass
        case plan_.Composition(members=members):
            for member in members:
                yield from _certain_invocations(member)


def _conflicts(
    scenario: Scenario, around: Environment, depth: int, visited: set[tuple[str, str]], examined: Invocations
) -> Iterator[NoSolution]:
    """Yield the conflicts within a scenario.

    Args:
        scenario: The scenario.
        around: Its environment, with its fixed fields.
        depth: Number of surrounding invocations.
        visited: Scenarios with their fixed fields that were visited before.
        examined: Returns the examined invocations in a behavior.
    """
    plan, visit = around.plan, (scenario.name, repr(sorted(around.instance.fields.items())))
    if visit in visited or depth > _MAX_DEPTH:
        return
    visited.add(visit)
    for invocation in examined(scenario.body):
        invoked, limits = plan.invoked(invocation), invocation.constraints
        given = fixed_values(invocation.arguments, around)
        passed = frozenset(name for name, _ in invocation.arguments)
        if invocation.modifications or invoked.modifiers:  # they may override any default
            passed = frozenset(invoked.structure.fields)
        if (conflict := _conflict(invocation, given, passed, around)) is not None:
            yield conflict
        elif isinstance(invoked, Scenario):
            inside = scope_of(invoked, given, passed, limits, plan)
            yield from _conflicts(invoked, inside, depth + 1, visited, examined)


def _conflict(
    invocation: InvokeScenario | InvokeAction, given: Mapping[str, Value], passed: Set[str], around: Environment
) -> NoSolution | None:
    plan, invoked = around.plan, around.plan.invoked(invocation)
    if not plan.is_bound(invocation):
        return None
    relaxed = Relaxation(invoked.structure, given, passed, invocation.constraints, around)
    if not relaxed.is_bound:
        return None
    try:
        _choose(invocation, given, relaxed, around)
    except NoSolution as error:
        if error.code == CONFLICT:
            places = (*error.places, (invocation.span, "invoked here"))
            return NoSolution(str(error), error.code, places, error.help)
    except EvaluationError:
        pass  # the run reports it
    return None


def choose_invoked(
    invocation: InvokeScenario | InvokeAction, fixed: Mapping[str, Value], plan: Plan, seed: int
) -> Mapping[str, Value]:
    """Choose values of the parameters of an invocation of the entry scenario, as far as the text fixes the others.

    Args:
        invocation: The invocation.
        fixed: Values of parameters of the entry scenario.
        plan: The plan.
        seed: Seed of the choice.

    Raises:
        NoSolution: The constraints contradict each other.
        EvaluationError: A value cannot be computed.
    """
    entry, invoked = plan.scenarios[plan.entry], plan.invoked(invocation)
    around = scope_of(entry, fixed, entry.structure.fields.keys() - fixed.keys(), (), plan)
    given = fixed_values(invocation.arguments, around)
    passed = frozenset(name for name, _ in invocation.arguments)
    relaxed = Relaxation(invoked.structure, given, passed, invocation.constraints, around)
    return _choose(invocation, given, relaxed, replace(around, seed=Seed(seed)))


def _choose(
    invocation: InvokeScenario | InvokeAction, given: Mapping[str, Value], relaxed: Relaxation, around: Environment
) -> Mapping[str, Value]:
    invoked, times = around.plan.invoked(invocation), _times(invocation, around)
    instance = Instance(invoked.name, Fields(), invoked, {})
    attempt = Invocation(given, None, relaxed.limits, around, around.seed, None, (), times)
    return choose_parameters(around.plan, (relaxed.structure,), instance, attempt)


def _times(invocation: InvokeScenario | InvokeAction, around: Environment) -> Times | None:
    plan, known = around.plan, around.instance.fields.keys()
    if DURATION in plan.invoked(invocation).structure.fields:
        return None
    if invocation.duration is not None and is_fixed(invocation.duration, known, plan.structures):
        with suppress(EvaluationError):  # the run reports it
            return times_of(invocation, around)
    return Times(invocation.span, {})
