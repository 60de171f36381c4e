"""Invocations in a plan."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.lang.plan import Action, Behavior, InvokeAction, InvokeScenario, OneOf, Parallel, Plan, Scenario, Serial


def invocations(plan: Plan) -> Iterator[InvokeAction]:
    """Yield all invocations of actions in a plan."""
    for scenario in plan.scenarios.values():
        yield from invocations_in(scenario.body)


def invocations_in(behavior: Behavior | None) -> Iterator[InvokeAction]:
    """Return all invocations of actions in a behavior."""
    return (each for each in invoked_in(behavior) if isinstance(each, InvokeAction))


def invoked_in(behavior: Behavior | None) -> Iterator[InvokeAction | InvokeScenario]:
    """Yield all invocations of actions and scenarios in a behavior."""
    match behavior:
        case InvokeAction() | InvokeScenario():
            yield behavior
        case Serial(members=members) | Parallel(members=members) | OneOf(members=members):
            for member in members:
                yield from invoked_in(member)
        case _:
            return


def declared_by(invocation: InvokeAction | InvokeScenario, plan: Plan) -> Action | Scenario:
    """Return the invoked declaration."""
    if isinstance(invocation, InvokeScenario):
        return plan.scenarios[invocation.scenario]
    return plan.actions[invocation.action]


def is_bound(invocation: InvokeAction | InvokeScenario, plan: Plan) -> bool:
    """Whether constraints affect the parameters of an invocation."""
    return bool(invocation.constraints) or not declared_by(invocation, plan).structure.is_plain


def may_conflict(plan: Plan) -> bool:
    """Whether a plan has any invocation with constraints."""
    return any(is_bound(each, plan) for scenario in plan.scenarios.values() for each in invoked_in(scenario.body))
