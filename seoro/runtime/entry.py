"""The instance of the entry scenario, with the values of its parameters."""

from __future__ import annotations

from seoro.errors import InvalidUse
from seoro.lang.plan import Plan
from seoro.runtime.applied import Modifying, apply, with_nested
from seoro.runtime.behaviors.invoke import OF_TYPE
from seoro.runtime.choose.fields import Fields
from seoro.runtime.environment import Environment, EvaluationError, NoChoice, Seed
from seoro.runtime.instances import Instance
from seoro.runtime.instantiate import entry_parameters
from seoro.runtime.method_context import MethodContext


def make_entry(plan: Plan, seed: int, run: MethodContext | None = None) -> tuple[Instance, tuple[Modifying, ...]]:
    """The instance of the entry scenario and its modifiers, all with their values.

    Args:
        plan: The plan.
        seed: What is drawn is drawn from it.
        run: For external methods that ask for it.

    Raises:
        InvalidUse: A value cannot be computed, or there are none that meet all constraints.
    """
    scenario = plan.scenarios[plan.entry]
    entry = Instance(scenario.name, Fields(), scenario, {})
    scope = Environment(entry, seed=Seed(seed), run=run)
    modifying = apply(scenario.modifiers, plan.modifiers, scope, entry, OF_TYPE)
    try:
        entry_parameters(plan, seed, run, entry, tuple(with_nested(modifying)))
    except NoChoice as error:
        raise InvalidUse(str(error), error.span, error.help, error.places, error.code) from error
    except EvaluationError as error:
        raise InvalidUse(str(error), error.span) from error
    return entry, modifying
