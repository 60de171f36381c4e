"""Invocations with arguments that contradict the constraints of the invoked declaration, found without a run.

An invocation is relaxed to parameters and constraints with values fixed by the text. Constraints with other
inputs, and defaults that these may override, are dropped. If the rest is contradictory, no run can carry out the
invocation.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import replace

from seoro.errors import CONFLICT
from seoro.lang import plan as plan_
from seoro.lang.plan import InvokeAction, InvokeScenario, Plan, Scenario, invocations_in
from seoro.runtime.behaviors.timing import times_of
from seoro.runtime.choose.slots import domain_of
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Instance
from seoro.runtime.instances.times import DURATION, Times
from seoro.runtime.parameters.parameters import Invocation, choose_parameters
from seoro.runtime.values.environment import Environment, EvaluationError, NoSolution
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


def fixed_values(
    expressions: Iterable[tuple[str, plan_.Expression]],
    known: Mapping[str, Value],
    around: Environment,
    plan: plan_.Plan,
) -> dict[str, Value]:
    """Return the values of the fixed expressions.

    Args:
        expressions: Expressions by name.
        known: Fixed fields of the instance of their scope.
        around: Environment of that scope.
        plan: The plan.
    """
    found: dict[str, Value] = {}
    for name, expression in expressions:
        if is_fixed(expression, known.keys(), plan.structures):
            try:
                found[name] = evaluate(expression, around)
            except EvaluationError:
                continue  # the run reports it
    return found


def scope_of(declared: plan_.Scenario | plan_.Action, known: Mapping[str, Value], plan: plan_.Plan) -> Environment:
    """Return the environment of an instance with some values."""
    fields = Fields()
    fields.update(known)
    return Environment(Instance(declared.name, fields, declared, {}), plan)


def known_in(
    declared: plan_.Scenario,
    given: Mapping[str, Value],
    passed: Set[str],
    limits: tuple[plan_.ConstraintMember, ...],
    plan: plan_.Plan,
) -> dict[str, Value]:
    """Return the fixed parameters of a scenario: given ones, and uncontested defaults.

    Args:
        declared: The scenario.
        given: Fixed values of arguments.
        passed: Names of all parameters with arguments.
        limits: Constraints of the invocation.
        plan: The plan.
    """
    known = dict(given)
    contested = passed | {name for each in (*declared.structure.members, *limits) for name in _read(each)}
    for field in declared.structure.fields.values():
        if field.default is not None and not field.is_variable and field.name not in contested:
            known |= fixed_values([(field.name, field.default)], known, scope_of(declared, known, plan), plan)
    return known


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
        passed: Names of all parameters with arguments.
        limits: Constraints of the invocation.
        known: Names of the fixed fields of the invoking scenario.
        plan: The plan.
    """

    def __init__(
        self,
        structure: plan_.Structure,
        given: Mapping[str, Value],
        passed: Set[str],
        limits: tuple[plan_.ConstraintMember, ...],
        known: Set[str],
        plan: plan_.Plan,
    ) -> None:
        self._given, self._known, self._plan = given, known, plan
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


def find_conflicts(plan: Plan) -> Iterator[NoSolution]:
    """Yield the conflicts of all reachable invocations, for values that the text fixes."""
    entry = plan.scenarios[plan.entry]
    known = {} if plan.overrides or entry.modifiers else known_in(entry, {}, frozenset(), (), plan)
    yield from _Search(plan).conflicts(entry, known, 0)


class _Search:
    """Visits invocations, starting at the entry scenario.

    Args:
        plan: The plan.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._visited: set[tuple[str, str]] = set()

    def conflicts(self, scenario: Scenario, known: Mapping[str, Value], depth: int) -> Iterator[NoSolution]:
        """Yield the conflicts within a scenario.

        Args:
            scenario: The scenario.
            known: Fixed values of its fields.
            depth: Number of surrounding invocations.
        """
        visit = (scenario.name, repr(sorted(known.items())))
        if visit in self._visited or depth > _MAX_DEPTH:
            return
        self._visited.add(visit)
        around = scope_of(scenario, known, self._plan)
        for invocation in invocations_in(scenario.body):
            given = fixed_values(invocation.arguments, known, around, self._plan)
            if self._plan.is_bound(invocation):
                conflict = self._conflict(invocation, given, known, around)
                if conflict is not None:
                    yield conflict
                    continue
            if isinstance(invocation, InvokeScenario):
                invoked = self._plan.scenarios[invocation.scenario]
                is_modified = bool(invocation.modifications or invoked.modifiers)
                passed = frozenset(name for name, _ in invocation.arguments)
                limits = invocation.constraints
                inner = given if is_modified else known_in(invoked, given, passed, limits, self._plan)
                yield from self.conflicts(invoked, inner, depth + 1)

    def _conflict(
        self,
        invocation: InvokeScenario | InvokeAction,
        given: Mapping[str, Value],
        known: Mapping[str, Value],
        around: Environment,
    ) -> NoSolution | None:
        declared = self._plan.invoked(invocation)
        passed = frozenset(name for name, _ in invocation.arguments)
        if invocation.modifications or declared.modifiers:  # they may override any default
            passed = frozenset(declared.structure.fields)
        relaxed = Relaxation(declared.structure, given, passed, invocation.constraints, known.keys(), self._plan)
        if not relaxed.is_bound:
            return None
        instance = Instance(declared.name, Fields(), declared, {})
        attempt = Invocation(
            given, None, relaxed.limits, around, around.seed, None, (), self._times(invocation, around)
        )
        try:
            choose_parameters(self._plan, relaxed.structure, instance, attempt, {})
        except NoSolution as error:
            return _at(error, invocation) if error.code == CONFLICT else None
        except EvaluationError:
            return None  # the run reports it
        return None

    def _times(self, invocation: InvokeScenario | InvokeAction, around: Environment) -> Times | None:
        if DURATION in self._plan.invoked(invocation).structure.fields:
            return None
        known = set(around.instance.fields)
        if invocation.duration is not None and is_fixed(invocation.duration, known, self._plan.structures):
            try:
                return times_of(invocation, around)
            except EvaluationError:
                pass  # the run reports it
        return Times(invocation.span, {})


def _at(error: NoSolution, invocation: InvokeScenario | InvokeAction) -> NoSolution:
    """Return a conflict with the place of the invocation."""
    return NoSolution(str(error), error.code, (*error.places, (invocation.span, "invoked here")), error.help)
