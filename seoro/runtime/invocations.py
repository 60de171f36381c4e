"""Where a plan invokes actions."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.lang.plan import Behavior, InvokeAction, OneOf, Parallel, Plan, Serial


def invocations(plan: Plan) -> Iterator[InvokeAction]:
    """All invocations of actions in a plan."""
    for scenario in plan.scenarios.values():
        yield from invocations_in(scenario.body)


def invocations_in(behavior: Behavior | None) -> Iterator[InvokeAction]:
    """All invocations of actions in a behavior of a scenario."""
    match behavior:
        case InvokeAction():
            yield behavior
        case Serial(members=members) | Parallel(members=members) | OneOf(members=members):
            for member in members:
                yield from invocations_in(member)
        case _:
            return
