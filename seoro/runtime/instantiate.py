"""New instances of scenarios and actions: their parameters get their values (7.3.6.1.1, 7.3.11)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, Protocol

from seoro.lang.plan import (
    Action,
    Constraint,
    ConstraintMember,
    Modifier,
    Plan,
    Scenario,
    Structure,
    behavior_type,
    modifier_type,
)
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import fill, is_plain
from seoro.runtime.choose.times import ANY_TIME, DURATION, Times, Window
from seoro.runtime.environment import Calls, Environment, Seed
from seoro.runtime.evaluate import evaluate
from seoro.runtime.method_context import MethodContext
from seoro.runtime.values import Actor, HasFields, Value

if TYPE_CHECKING:
    from seoro.runtime.applied import Applied


@dataclass(eq=False)
class Parameters:
    """The parameters of an instance, while they get their values.

    Args:
        types: What `plan.Methods` calls its type and what that inherits, nearest first.
        fields: The values.
    """

    types: tuple[str, ...]
    fields: Fields = field(default_factory=Fields)
    windows: Mapping[str, Window] = field(default_factory=dict)


class Invocation(NamedTuple):
    """What an invocation says about an instance.

    Args:
        given: Values of parameters.
        actor: The actor that it is invoked on.
        constraints: What else holds for the instance.
        around: The scope of the invocation; None if there is none.
        seed: What is drawn for the instance is drawn from it.
        run: For external methods that ask for it.
        applied: The modifiers of the instance; those that have no values yet get theirs.
        times: Its parameters for times.
    """

    given: Mapping[str, Value]
    actor: Actor | None
    constraints: tuple[ConstraintMember, ...]
    around: Environment | None
    seed: Seed
    run: MethodContext | None
    applied: tuple[Applied, ...] = ()
    times: Times | None = None


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

    windows: Mapping[str, Window]  # of its times that anything is said about


def types_of(declared: Scenario | Action | Modifier) -> tuple[str, ...]:
    """What `plan.Methods` calls a scenario, an action or a modifier and what it inherits, nearest first."""
    if isinstance(declared, Modifier):
        return (modifier_type(declared.name),)
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
    times = Times(scenario.span, {})
    invocation = Invocation({}, None, (), None, Seed(seed), run, applied, times)
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


def take_given(fields: Fields, given: Mapping[str, Value], shared: Mapping[str, Value]) -> None:
    """What `choose_parameters` comes to where all parameters are given, and nothing is said about times.

    Args:
        fields: Of the instance.
        given: The values of its parameters.
        shared: The values of the global parameters.
    """
    fields.update(shared)
    fields.update(given)
    fields.setdefault(DURATION, ANY_TIME)


def choose_times(plan: Plan, made: Made, invocation: Invocation) -> None:
    """Give a composition, and what modifies it, their values.

    Args:
        plan: The plan.
        made: What stands for the composition.
        invocation: What holds for its times, and what modifies it.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    _choose(plan, (), made, invocation, ())


def _choose(
    plan: Plan,
    roots: tuple[Structure, ...],
    made: Made,
    invocation: Invocation,
    overrides: tuple[Constraint, ...],
) -> dict[str, Value]:
    given, fields = invocation.given, made.fields
    is_free = not (invocation.constraints or overrides) and all(is_plain(root, given) for root in roots)
    if is_free and all(applied.is_plain for applied in invocation.applied):
        fields.update(given)
        if invocation.times is not None:
            values, made.windows = invocation.times.plain()
            for name, value in values.items():
                fields.setdefault(name, value)
        for root in roots:
            if not root.fields.keys() <= fields.keys():
                fill(fields, root, plan.structures, _scope(made, invocation), evaluate)
        for applied in invocation.applied:
            applied.fill(plan.structures)
        return fields
    from seoro.runtime.choose.choose import choose  # noqa: PLC0415 - seldom needed
    from seoro.runtime.choose.request import Request  # noqa: PLC0415 - the same

    around = invocation.around
    calls = Calls()
    environment = replace(_scope(made, invocation), calls=calls)
    if around is not None:
        around = replace(around, bindings={**around.bindings, "it": made}, calls=calls)
    made.windows = choose(
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
            times=invocation.times,
        )
    )
    return fields


def _scope(made: Made, invocation: Invocation) -> Environment:
    """What names stand for in what an instance says of itself."""
    bindings: dict[str, Value | HasFields] = {}
    if invocation.actor is not None:
        bindings["actor"] = invocation.actor
    return Environment(made, bindings, seed=invocation.seed, run=invocation.run)
