"""`emit` (7.3.10.2): emits an event. `end` or `fail` of the enclosing scenario ends that scenario.

- It takes no time, and takes effect between this delta cycle and the next.
"""

from __future__ import annotations

from functools import partial

from seoro.lang.plan import DeclaredEvent, Emit, Phase, PhaseEvent
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Value
from seoro.runtime.verdict import SUCCEEDED, Outcome, failure


def run_emit(plan: Emit, context: ExecutionContext, environment: Environment, past: CausalPast) -> Outcome:
    """Emit an event.

    Args:
        plan: The `emit`.
        context: Its context.
        environment: Its environment.
        past: Past of the emitter; the occurrence is added.
    """
    event = plan.event
    context.services.emitted[id(plan)] = context.scheduler.now
    if isinstance(event, PhaseEvent) and event.label is None and event.phase is not Phase.START:
        scope = context.instance.scope
        assert scope is not None, "its scenario is running"
        context.scheduler.at_commit(context.position, partial(_end, scope, plan, context), past.cause)
        return SUCCEEDED
    arguments: dict[str, Value] = {}
    if isinstance(event, DeclaredEvent):
        declared = context.instance.events[event.name]
        given = declared.all_arguments(plan.arguments)
        arguments = {name: evaluate(given[name], environment) for name, _ in declared.parameters}
    events = context.services.events
    events.emit(events.own(context.instance, event), arguments, past)
    return SUCCEEDED


def _end(scope: CancelScope, plan: Emit, context: ExecutionContext) -> None:
    """End the enclosing scenario; a failure is explained by the activities after this delta cycle."""
    is_failed = isinstance(plan.event, PhaseEvent) and plan.event.phase is Phase.FAIL
    scope.cancel(context.explained(failure("`emit fail`", plan.span), scope) if is_failed else SUCCEEDED)
