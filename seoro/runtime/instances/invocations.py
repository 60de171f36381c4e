"""Invocations in a plan."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.lang.plan import Action, InvokeAction, InvokeScenario, Plan, Scenario, invocations_in


def invocations(plan: Plan) -> Iterator[InvokeAction]:
    """Yield all invocations of actions in a plan."""
    for scenario in plan.scenarios.values():
        yield from (each for each in invocations_in(scenario.body) if isinstance(each, InvokeAction))


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
    return any(
        is_bound(each, plan) for scenario in plan.scenarios.values() for each in invocations_in(scenario.body)
    )
