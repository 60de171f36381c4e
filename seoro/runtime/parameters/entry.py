"""The instance of the entry scenario, with the values of its parameters."""

from __future__ import annotations

from seoro.errors import UsageError
from seoro.lang.plan import Plan
from seoro.runtime.instances.applied import OF_TYPE, Modifying, apply, with_nested
from seoro.runtime.instances.instances import Instance
from seoro.runtime.parameters.parameters import entry_parameters
from seoro.runtime.values.environment import Environment, EvaluationError, NoSolution, Seed
from seoro.runtime.values.fields import Fields
from seoro.runtime.values.method_context import MethodContext


def make_entry(plan: Plan, seed: int, run: MethodContext | None = None) -> tuple[Instance, tuple[Modifying, ...]]:
    """Create the instance of the entry scenario and its modifiers, with values.

    Args:
        plan: The plan.
        seed: Seed of random values.
        run: The run, for external methods.

    Raises:
        UsageError: A value cannot be computed, or no values meet all constraints.
    """
    scenario = plan.scenarios[plan.entry]
    entry = Instance(scenario.name, Fields(), scenario, {})
    scope = Environment(entry, plan, seed=Seed(seed), run=run)
    modifying = apply(scenario.modifiers, plan.modifiers, scope, entry, OF_TYPE)
    try:
        entry_parameters(plan, seed, run, entry, tuple(with_nested(modifying)))
    except NoSolution as error:
        raise UsageError(str(error), error.span, error.help, error.places, error.code) from error
    except EvaluationError as error:
        raise UsageError(str(error), error.span) from error
    return entry, modifying
