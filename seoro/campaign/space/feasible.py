"""Check of values against the constraints of a scenario, without a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.embed.scenarios import Scenario
from seoro.errors import CONFLICT, InvalidScenario, UsageError
from seoro.lang.frozen import Value

_SEED = 0  # whether values exist does not depend on it


class Feasibility(Value):
    """Predicate of values.

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
            values: Values of some parameters by path, in the notation of the scenario.
        """
        from seoro.runtime.parameters.parameters import make_entry  # noqa: PLC0415 - loads most of the runtime

        try:
            overrides = {**self.overrides, **values}
            make_entry(self.scenario.plan(self.name, overrides, self.constraints), _SEED)
        except UsageError as error:
            return error.code != CONFLICT
        except InvalidScenario:
            return True
        return True
