"""Constraints of the entry scenario that cannot hold together, found without running anything."""

from __future__ import annotations

from seoro.embed.scenarios import Scenario
from seoro.errors import InvalidScenario, InvalidUse
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.frontend import lower
from seoro.lang.plan import Plan

_CONFLICT = "E0442"


def find_contradictions(scenario: Scenario) -> tuple[Diagnostic, ...]:
    """The conflict of constraints that `seoro exec` would report, if there is one.

    A file without errors is instantiated if it has one entry scenario. Values that only an override can give are
    no error here. External methods are called, as for a run.
    """
    if scenario.checked.errors:
        return ()
    try:
        plan = lower(scenario.checked, None)
    except InvalidScenario:
        return ()  # no entry, or a value that an override has to give
    if not _has_constraints(plan):
        return ()
    from seoro.runtime.entry import make_entry  # noqa: PLC0415 - loads most of the runtime

    try:
        make_entry(plan, 0)
    except InvalidUse as error:
        found = error.diagnostic
        return (found,) if found is not None and found.code == _CONFLICT else ()
    return ()


def _has_constraints(plan: Plan) -> bool:
    """Whether anything but given values and defaults decides about values of the entry scenario."""
    scenario = plan.scenarios[plan.entry]
    structures = (plan.globals, scenario.structure, *plan.structures.all())
    return bool(scenario.modifiers) or not all(structure.is_plain for structure in structures)
