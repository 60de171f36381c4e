"""Invocation of a scenario: runs its `do` (7.3.5.1.3)."""

from __future__ import annotations

from collections.abc import Awaitable

from seoro.lang.plan import Scenario
from seoro.runtime.behaviors.invoke import run_instance
from seoro.runtime.execution.context import ExecutionContext, Perform
from seoro.runtime.instances.instances import Instance
from seoro.runtime.verdict import SUCCEEDED, Outcome


def run_scenario(instance: Instance, context: ExecutionContext, perform: Perform) -> Awaitable[Outcome]:
    """Run an instance of a scenario."""
    declaration = instance.declaration
    assert isinstance(declaration, Scenario)
    body = declaration.body

    async def nothing() -> Outcome:
        return SUCCEEDED

    def carry(inside: ExecutionContext) -> Awaitable[Outcome]:
        return perform(body, inside.member(0, body)) if body is not None else nothing()

    return run_instance(instance, context, carry)
