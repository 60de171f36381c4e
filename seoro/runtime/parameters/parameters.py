"""Parameters of new scenario and action instances (7.3.6.1.1, 7.3.11), and of modifiers applied to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple, TypeAlias

from seoro.errors import UsageError
from seoro.lang.plan import Constraint, ConstraintMember, Plan, Structure
from seoro.runtime.choose.plain import fill, is_plain
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.applied import OF_TYPE, Applied, Modifying, apply, with_nested
from seoro.runtime.instances.instances import Composed, Instance, types_of
from seoro.runtime.instances.times import ANY_TIME, DURATION, Times
from seoro.runtime.values.environment import Calls, Environment, EvaluationError, MethodContext, NoSolution, Seed
from seoro.runtime.values.values import Actor, Fields, HasFields, Value


def actor_of(applied: Applied) -> Actor | None:
    """Return the actor of a modifier."""
    actor = evaluate(applied.plan.actor, applied.around) if applied.plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    return actor


def is_plain_modifier(applied: Applied) -> bool:
    """Whether a modifier needs no choice, neither for itself nor for the modified behavior."""
    structure = applied.modifier.structure
    if applied.has_values:
        return structure.is_plain
    given: dict[str, Value] = {name: True for name, _ in applied.plan.arguments}
    return not applied.plan.ranges and is_plain(structure, given)


def fill_modifier(applied: Applied) -> None:
    """Fill the values of a modifier that needs no choice.

    Raises:
        EvaluationError: An argument or a default has no value.
    """
    if not applied.has_values:
        for name, value in applied.plan.arguments:
            applied.fields[name] = evaluate(value, applied.around)
        fill(applied.fields, applied.modifier.structure, applied.inside, evaluate)


def enter_modifier(applied: Applied, path: str) -> Instance:
    """Create an instance of a modifier for a run of the modified behavior.

    Args:
        applied: The modifier.
        path: Its position, as text.

    Raises:
        EvaluationError: A variable has no value.
    """
    structure, fields = applied.modifier.structure, applied.fields
    if applied.is_entered:
        fields = Fields()
        parameters = (declared.name for declared in structure.fields.values() if not declared.is_variable)
        fields.update((name, applied.fields[name]) for name in parameters)
    instance = Instance(path, fields, applied.modifier, applied.bindings, applied.inside.scenario)
    if applied.is_entered:
        fill(fields, structure, replace(applied.inside, instance=instance), evaluate)
    applied.is_entered = True
    return instance


class Invocation(NamedTuple):
    """Data of an invocation for its instance.

    Args:
        given: Values of parameters.
        actor: Actor of the invocation.
        constraints: Constraints on the instance.
        around: Environment of the invocation, or None.
        seed: Seed of random values.
        run: The run, for external methods.
        applied: Modifiers of the instance, with or without values.
        times: Its timing parameters.
    """

    given: Mapping[str, Value]
    actor: Actor | None
    constraints: tuple[ConstraintMember, ...]
    around: Environment | None
    seed: Seed
    run: MethodContext | None
    applied: tuple[Applied, ...] = ()
    times: Times | None = None


Made: TypeAlias = Instance | Composed
"""An instance while its parameters get their values."""


def entry_parameters(
    plan: Plan,
    seed: int,
    run: MethodContext | None = None,
    made: Made | None = None,
    applied: tuple[Applied, ...] = (),
) -> dict[str, Value]:
    """Choose the values of global parameters and of the parameters of the entry scenario.

    Args:
        plan: The plan.
        seed: Seed of random values.
        run: The run, for external methods.
        made: Existing instance that gets the values, or None.
        applied: Its modifiers, which get values too.

    Raises:
        EvaluationError: A value cannot be computed, or no values meet all constraints.
    """
    scenario = plan.scenarios[plan.entry]
    roots = (plan.globals, scenario.structure)
    times = Times(scenario.span, {}) if DURATION not in scenario.structure.fields else None
    invocation = Invocation({}, None, (), None, Seed(seed), run, applied, times)
    made = made or Composed(scenario.name, Fields(), types=types_of(scenario))
    return choose_parameters(plan, roots, made, invocation, plan.overrides)


def take_given(fields: Fields, given: Mapping[str, Value], shared: Mapping[str, Value]) -> None:
    """Set the parameters where all are given and times are unconstrained; equals `choose_parameters` then.

    Args:
        fields: Fields of the instance.
        given: Values of its parameters.
        shared: Values of global parameters.
    """
    fields.update(shared)
    fields.update(given)
    fields.setdefault(DURATION, ANY_TIME)


def choose_parameters(
    plan: Plan,
    roots: tuple[Structure, ...],
    made: Made,
    invocation: Invocation,
    overrides: tuple[Constraint, ...] = (),
) -> dict[str, Value]:
    """Choose the values of an instance and of its modifiers; return those of the instance.

    Args:
        plan: The plan.
        roots: Structures of the instance; none for a composition, which has times only.
        made: The instance; its fields have the values of global parameters.
        invocation: Data of the invocation.
        overrides: Constraints by the user.

    Raises:
        EvaluationError: A value cannot be computed, or no values meet all constraints.
    """
    given, fields = invocation.given, made.fields
    is_free = not (invocation.constraints or overrides) and all(is_plain(root, given) for root in roots)
    if is_free and all(map(is_plain_modifier, invocation.applied)):
        fields.update(given)
        if invocation.times is not None:
            values, made.windows = invocation.times.plain()
            for name, value in values.items():
                fields.setdefault(name, value)
        for root in roots:
            if not root.fields.keys() <= fields.keys():
                fill(fields, root, _scope(plan, made, invocation), evaluate)
        for applied in invocation.applied:
            fill_modifier(applied)
        return fields
    if overrides and _settle(plan, roots, made, invocation, overrides):
        return fields
    from seoro.runtime.choose.choose import choose  # noqa: PLC0415 - rarely needed

    around = invocation.around
    calls = Calls()
    environment = replace(_scope(plan, made, invocation), calls=calls)
    if around is not None:
        around = replace(around, bindings={**around.bindings, "it": made}, calls=calls)
    made.windows = choose(
        made,
        roots,
        given,
        environment,
        evaluate,
        constraints=invocation.constraints,
        around=around,
        overrides=overrides,
        attached=tuple(applied.attached(calls) for applied in invocation.applied),
        times=invocation.times,
    )
    return fields


def _settle(
    plan: Plan,
    roots: tuple[Structure, ...],
    made: Made,
    invocation: Invocation,
    overrides: tuple[Constraint, ...],
) -> bool:
    """Set the values of the entry scenario if overrides settle them."""
    if invocation.applied or invocation.times is None:
        return False
    from seoro.runtime.choose.settled import settle  # noqa: PLC0415 - for runs with overrides only

    times, windows = invocation.times.plain()
    is_settled = settle(made.fields, roots, overrides, times, _scope(plan, made, invocation), evaluate)
    if is_settled:
        made.windows = windows
    return is_settled


def _scope(plan: Plan, made: Made, invocation: Invocation) -> Environment:
    """Return the environment of an instance's own constraints."""
    bindings: dict[str, Value | HasFields] = {}
    if invocation.actor is not None:
        bindings["actor"] = invocation.actor
    return Environment(made, plan, bindings, seed=invocation.seed, run=invocation.run)


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
