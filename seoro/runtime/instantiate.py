"""New instances of scenarios and actions: their parameters get their values (7.3.6.1.1, 7.3.11)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING, Protocol

from seoro.lang import frozen
from seoro.lang.plan import Action, Constraint, ConstraintMember, Plan, Scenario, Structure, behavior_type
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import fill, is_plain
from seoro.runtime.environment import Calls, Environment, Seed
from seoro.runtime.evaluate import evaluate
from seoro.runtime.method_context import MethodContext
from seoro.runtime.values import Actor, HasFields, Value

if TYPE_CHECKING:
    from seoro.runtime.applied import Applied


class Parameters(frozen.Frozen):
    """The parameters of an instance, while they get their values.

    Args:
        types: What `plan.Methods` calls its type and what that inherits, nearest first.
        fields: The values.
    """

    types: tuple[str, ...]
    fields: Fields = field(default_factory=Fields)


class Invocation(frozen.Value):
    """What an invocation says about an instance.

    Args:
        given: Values of parameters.
        actor: The actor that it is invoked on.
        constraints: What else holds for the instance.
        around: The scope of the invocation; None if there is none.
        seed: What is drawn for the instance is drawn from it.
        run: For external methods that ask for it.
        applied: The modifiers of the instance; those that have no values yet get theirs.
    """

    given: Mapping[str, Value]
    actor: Actor | None
    constraints: tuple[ConstraintMember, ...]
    around: Environment | None
    seed: Seed
    run: MethodContext | None
    applied: tuple[Applied, ...] = ()


class Made(Protocol):
    """An instance, while its parameters get their values."""

    @property
    def fields(self) -> Fields:
        """The values."""
        ...

    @property
    def types(self) -> tuple[str, ...]:
        """What `plan.Methods` calls its type and what that inherits, nearest first."""
        ...


def types_of(declared: Scenario | Action) -> tuple[str, ...]:
    """What `plan.Methods` calls a scenario or an action and what it inherits, nearest first."""
    return (behavior_type(declared.name), *map(behavior_type, declared.bases))


def entry_parameters(
    plan: Plan,
    seed: int,
    run: MethodContext | None = None,
    made: Made | None = None,
    applied: tuple[Applied, ...] = (),
) -> dict[str, Value]:
    """The values of the global parameters, and of the parameters of the entry scenario.

    Args:
        plan: The plan.
        seed: What is drawn is drawn from it.
        run: For external methods that ask for it.
        made: The instance, if there is one already; it gets the values.
        applied: Its modifiers; those get theirs.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    scenario = plan.scenarios[plan.entry]
    invocation = Invocation({}, None, (), None, Seed(seed), run, applied)
    roots = (plan.globals, scenario.structure)
    return _choose(plan, roots, made or Parameters(types_of(scenario)), invocation, plan.overrides)


def choose_parameters(
    plan: Plan, structure: Structure, made: Made, invocation: Invocation, shared: Mapping[str, Value]
) -> None:
    """Give something that is invoked, and what modifies it, their values.

    Args:
        plan: The plan.
        structure: What it is made of.
        made: The instance.
        invocation: What the invocation says.
        shared: The values of the global parameters.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    made.fields.update(shared)
    _choose(plan, (structure,), made, invocation, ())


def choose_for_modifiers(plan: Plan, invocation: Invocation) -> None:
    """Give the modifiers of a composition their values.

    Args:
        plan: The plan.
        invocation: Says no more than which they are, and the scope around.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    _choose(plan, (), Parameters(()), invocation, ())


def _choose(
    plan: Plan,
    roots: tuple[Structure, ...],
    made: Made,
    invocation: Invocation,
    overrides: tuple[Constraint, ...],
) -> dict[str, Value]:
    given, fields = invocation.given, made.fields
    bindings: dict[str, Value | HasFields] = {}
    if invocation.actor is not None:
        bindings["actor"] = invocation.actor
    environment = Environment(made, bindings, seed=invocation.seed, run=invocation.run)
    is_free = not (invocation.constraints or overrides) and all(is_plain(root, given) for root in roots)
    if is_free and all(applied.is_plain for applied in invocation.applied):
        fields.update(given)
        for root in roots:
            fill(fields, root, plan.structures, environment, evaluate)
        for applied in invocation.applied:
            applied.fill(plan.structures)
        return fields
    from seoro.runtime.choose.choose import Request, choose  # noqa: PLC0415 - seldom needed

    around = invocation.around
    calls = Calls()
    environment = replace(environment, calls=calls)
    if around is not None:
        around = replace(around, bindings={**around.bindings, "it": made}, calls=calls)
    choose(
        Request(
            holder=made,
            roots=roots,
            given=given,
            environment=environment,
            structures=plan.structures,
            evaluate=evaluate,
            constraints=invocation.constraints,
            around=around,
            overrides=overrides,
            attached=tuple(applied.attached(calls) for applied in invocation.applied),
        )
    )
    return fields
