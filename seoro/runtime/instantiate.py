"""New instances of scenarios and actions: their parameters get their values (7.3.6.1.1, 7.3.11)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from hashlib import sha256

from seoro.lang.plan import Action, Constraint, ConstraintMember, Plan, Scenario, Structure, behavior_type
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import fill, is_plain
from seoro.runtime.environment import Calls, Environment
from seoro.runtime.evaluate import evaluate
from seoro.runtime.method_context import MethodContext
from seoro.runtime.values import Actor, HasFields, Value


@dataclass(frozen=True, eq=False)
class Parameters:
    """The parameters of an instance, while they get their values.

    Args:
        types: What `plan.Methods` calls its type and what that inherits, nearest first.
        fields: The values.
    """

    types: tuple[str, ...]
    fields: Fields = field(default_factory=Fields)


@dataclass(frozen=True)
class Invocation:
    """What an invocation says about an instance.

    Args:
        given: Values of parameters.
        actor: The actor that it is invoked on.
        constraints: What else holds for the instance.
        around: The scope of the invocation; None if there is none.
        seed: What is drawn for the instance is drawn from it.
        run: For external methods that ask for it.
    """

    given: Mapping[str, Value]
    actor: Actor | None
    constraints: tuple[ConstraintMember, ...]
    around: Environment | None
    seed: int
    run: MethodContext | None


def types_of(declared: Scenario | Action) -> tuple[str, ...]:
    """What `plan.Methods` calls a scenario or an action and what it inherits, nearest first."""
    return (behavior_type(declared.name), *map(behavior_type, declared.bases))


def entry_parameters(plan: Plan, seed: int, run: MethodContext | None = None) -> dict[str, Value]:
    """The values of the global parameters, and of the parameters of the entry scenario.

    Args:
        plan: The plan.
        seed: What is drawn is drawn from it.
        run: For external methods that ask for it.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    scenario = plan.scenarios[plan.entry]
    invocation = Invocation({}, None, (), None, seed, run)
    roots = (plan.globals, scenario.structure)
    return _choose(plan, roots, Parameters(types_of(scenario)), invocation, plan.overrides)


def parameters(
    plan: Plan, declared: Scenario | Action, invocation: Invocation, shared: Mapping[str, Value]
) -> dict[str, Value]:
    """The values of the parameters of something that is invoked.

    Args:
        plan: The plan.
        declared: What is invoked.
        invocation: What the invocation says.
        shared: The values of the global parameters.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    made = Parameters(types_of(declared))
    made.fields.update(shared)
    return _choose(plan, (declared.structure,), made, invocation, ())


def derived_seed(seed: int, purpose: str) -> int:
    """A seed for one purpose, the same on any machine."""
    return int.from_bytes(sha256(f"{seed}/{purpose}".encode()).digest()[:8], "big")


def _choose(
    plan: Plan,
    roots: tuple[Structure, ...],
    made: Parameters,
    invocation: Invocation,
    overrides: tuple[Constraint, ...],
) -> dict[str, Value]:
    given, fields = invocation.given, made.fields
    bindings: dict[str, Value | HasFields] = {}
    if invocation.actor is not None:
        bindings["actor"] = invocation.actor
    environment = Environment(made, bindings, seed=invocation.seed, run=invocation.run)
    if not (invocation.constraints or overrides) and all(is_plain(root, given) for root in roots):
        fields.update(given)
        for root in roots:
            fill(fields, root, plan.structures, environment, evaluate)
        return fields
    from seoro.runtime.choose.choose import Request, choose  # noqa: PLC0415 - seldom needed

    around = invocation.around
    environment = replace(environment, calls=Calls())
    if around is not None:
        around = replace(around, bindings={**around.bindings, "it": made}, calls=environment.calls)
    choose(
        Request(
            made, roots, given, environment, plan.structures, evaluate, invocation.constraints, around, overrides
        )
    )
    return fields
