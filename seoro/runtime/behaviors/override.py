"""`override(<overridden>, <by>[, <mode>])` (7.3.12.1.1): the start of a behavior ends another one.

It is active while the modified behavior runs, from the delta cycle after its start to that of its end. With
`when_active`, the overridden behavior does not start while the other one runs; this is checked first. If behaviors
that start in one delta cycle override each other, the first in the text continues. The overridden behavior is
cancelled, and the behavior around it continues as if it had ended.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from seoro.lang.plan import LabelPath, Override, OverrideMode
from seoro.runtime.execution.context import Carry, ExecutionContext
from seoro.runtime.execution.services import Overriding
from seoro.runtime.instances.instances import Instance
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.verdict import Outcome, Status


async def run_override(plan: Override, context: ExecutionContext, inner: Carry) -> Outcome:
    """Run the modified behavior with the override active."""
    instance = context.instance
    invoked = context.invoked.instance if context.invoked is not None else None
    if isinstance(invoked, Instance) and plan in invoked.declaration.modifiers:
        instance = invoked
    overriding, scheduler = Overriding(plan, instance), context.scheduler
    held = context.services.overriding
    scheduler.write(context.position, partial(held.setdefault, overriding))
    try:
        return await inner(context)
    finally:
        scheduler.write(context.position, partial(held.pop, overriding))


def is_overridden(label: str, context: ExecutionContext) -> Outcome | None:
    """Return the outcome of a labelled behavior that must not start now; None if it may start."""
    for overriding in context.services.overriding:
        plan = overriding.plan
        if plan.mode is OverrideMode.ON_START or not _is(overriding, plan.overridden, context.instance, label):
            continue
        if _running(overriding.instance, plan.by) is not None:
            return replace(_outcome(plan), has_begun=False)
    return None


def start_labelled(label: str, context: ExecutionContext, scope: CancelScope) -> None:
    """Register a running labelled behavior, and end the behaviors that it overrides at commit."""
    running = context.instance.running
    context.scheduler.write(context.position, partial(running.__setitem__, label, scope))
    context.scheduler.at_commit(
        context.position, partial(_end_overridden, label, context, scope), context.task.past.cause
    )


def end_labelled(label: str, context: ExecutionContext, scope: CancelScope) -> None:
    """Unregister a labelled behavior at commit."""

    def commit() -> None:
        if context.instance.running.get(label) is scope:
            del context.instance.running[label]

    context.scheduler.write(context.position, commit)


def _end_overridden(label: str, context: ExecutionContext, scope: CancelScope) -> None:
    if scope.is_cancelled:
        return  # cancelled by a behavior that started in the same delta cycle
    for overriding in tuple(context.services.overriding):
        if _is(overriding, overriding.plan.by, context.instance, label):
            overridden = _running(overriding.instance, overriding.plan.overridden)
            if overridden is not None and overridden is not scope:
                overridden.cancel(_outcome(overriding.plan))


def _outcome(plan: Override) -> Outcome:
    return Outcome(Status.CANCELLED, f"overridden by `{'.'.join(plan.by)}`", plan.span)


def _holder(instance: Instance, path: LabelPath) -> Instance | None:
    """Return the instance that contains the last label of a path."""
    holder: Instance | None = instance
    for label in path[:-1]:
        holder = holder.latest(label).instance if holder is not None else None
    return holder


def _is(overriding: Overriding, path: LabelPath, instance: Instance, label: str) -> bool:
    """Whether a path leads to a labelled behavior."""
    return path[-1] == label and _holder(overriding.instance, path) is instance


def _running(instance: Instance, path: LabelPath) -> CancelScope | None:
    """Return the scope of the running behavior of a path, or None."""
    holder = _holder(instance, path)
    return holder.running.get(path[-1]) if holder is not None else None
