"""Invocations with arguments that contradict the constraints of the invoked declaration, found without a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from seoro.errors import CONFLICT
from seoro.lang.plan import InvokeAction, InvokeScenario, Plan, Scenario, invocations_in
from seoro.runtime.behaviors.timing import times_of
from seoro.runtime.feasibility.relaxation import Relaxation, fixed_values, is_fixed, known_in, scope_of
from seoro.runtime.instances.instances import Instance
from seoro.runtime.instances.times import DURATION, Times
from seoro.runtime.parameters.parameters import Invocation, choose_parameters
from seoro.runtime.values.environment import Environment, EvaluationError, NoSolution
from seoro.runtime.values.values import Fields, Value

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
        said = Invocation(
            given, None, relaxed.limits, around, around.seed, None, (), self._times(invocation, around)
        )
        try:
            choose_parameters(self._plan, relaxed.structure, instance, said, {})
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
