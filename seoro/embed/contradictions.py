"""Detection of contradictory constraints without a run."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.embed.scenarios import Scenario
from seoro.errors import CONFLICT, InvalidScenario, UsageError
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.frontend import lower
from seoro.lang.plan import Plan


def find_contradictions(scenario: Scenario) -> Iterator[Diagnostic]:
    """Yield the conflicts of constraints that `seoro exec` would report.

    The entry scenario of a file without errors is instantiated, then its invocations with constant arguments.
    Missing values that an override can set are not reported. External methods are called, as in a run.
    """
    if scenario.checked.errors:
        return
    try:
        plan = lower(scenario.checked, None)
    except InvalidScenario:
        return  # no entry scenario, or a missing value that an override can set
    if _has_constraints(plan):
        yield from _entry_conflict(plan)
    yield from _invocation_conflicts(plan)


def _entry_conflict(plan: Plan) -> Iterator[Diagnostic]:
    from seoro.runtime.parameters.parameters import make_entry  # noqa: PLC0415 - loads most of the runtime

    try:
        make_entry(plan, 0)
    except UsageError as error:
        found = error.diagnostic
        if found is not None and found.code == CONFLICT:
            yield found


def _invocation_conflicts(plan: Plan) -> Iterator[Diagnostic]:
    if not any(map(plan.is_bound, plan.invocations())):
        return
    from seoro.runtime.feasibility.conflicts import find_conflicts  # noqa: PLC0415 - loads most of the runtime

    for conflict in find_conflicts(plan):
        found = UsageError(str(conflict), conflict.span, conflict.help, conflict.places, conflict.code).diagnostic
        assert found is not None, "it has a place"
        yield found


def _has_constraints(plan: Plan) -> bool:
    """Return whether values of the entry scenario depend on more than given values and defaults."""
    scenario = plan.scenarios[plan.entry]
    structures = (plan.globals, scenario.structure, *plan.structures.all())
    return bool(scenario.modifiers) or not all(structure.is_plain for structure in structures)
