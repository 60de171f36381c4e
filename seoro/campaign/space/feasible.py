"""Check of values against the constraints of a scenario, without a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from seoro.embed.scenarios import Scenario
from seoro.embed.world_settings import split_world
from seoro.errors import CONFLICT, InvalidScenario, UsageError
from seoro.lang.frozen import Value
from seoro.lang.plan import Compare, Field, Plan

_SEED = 0  # whether values exist does not depend on it


class Feasibility(Value):
    """Predicate of values: whether constraints of the entry scenario and of its invocations allow them.

    Args:
        scenario: The loaded scenario.
        name: Name of the entry scenario, or None.
        overrides: Values of parameters that all runs share.
        constraints: Constraints from outside that all runs share.
    """

    scenario: Scenario
    name: str | None
    overrides: Mapping[str, str]
    constraints: Sequence[str] = ()

    def __call__(self, values: Mapping[str, str]) -> bool:
        """Return whether the solver finds values for the other parameters.

        Values that fail for another reason, such as a method that needs a run, count as feasible. The run reports
        the reason.

        Args:
            values: Values of some parameters by path, in the notation of the scenario; worlds are ignored.
        """
        from seoro.runtime.feasibility.conflicts import find_certain_conflicts  # noqa: PLC0415 - see below
        from seoro.runtime.parameters.parameters import make_entry  # noqa: PLC0415 - loads most of the runtime

        try:
            of_scenario, _ = split_world({**self.overrides, **values})
            plan = self.scenario.plan(self.name, of_scenario, self.constraints)
            entry, _ = make_entry(plan, _SEED)
        except UsageError as error:
            return error.code != CONFLICT
        except InvalidScenario:
            return True
        fixed = {name: entry.fields[name] for name in fixed_parameters(plan)}
        return next(find_certain_conflicts(plan, fixed), None) is None


def fixed_parameters(plan: Plan) -> Iterator[str]:
    """Yield the names of parameters of the entry scenario with a value from outside."""
    for each in plan.overrides:
        match each.condition:
            case Compare("==", Field(name), _):
                yield name
