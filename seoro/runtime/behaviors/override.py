"""`override(<overridden>, <by>[, <mode>])` (7.3.12.1.1): a behavior ends when another one starts.

It holds while what it modifies runs, from the round after that one's start to the round of its end. With
`when_active`, the overridden behavior does not even start while the other one runs; that is asked first. Of
behaviors that start in one round and override each other, the first in the text goes on. What is overridden is
cancelled: what stands around it goes on as if it had ended.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from seoro.lang.plan import LabelPath, Override, OverrideMode
from seoro.runtime.agenda import Scope
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.instances import Instance
from seoro.runtime.place import Place
from seoro.runtime.services import Overriding
from seoro.runtime.verdict import Outcome, Status


async def run_override(plan: Override, place: Place, inner: Carry) -> Outcome:
    """Carry out what it modifies, while it holds."""
    instance = place.instance
    invoked = place.invoked.instance if place.invoked is not None else None
    if isinstance(invoked, Instance) and plan in invoked.declaration.modifiers:
        instance = invoked
    overriding, agenda = Overriding(plan, instance), place.agenda
    held = place.services.overriding
    agenda.write(place.position, partial(held.setdefault, overriding))
    try:
        return await inner(place)
    finally:
        agenda.write(place.position, partial(held.pop, overriding))


def is_overridden(label: str, place: Place) -> Outcome | None:
    """The outcome of a labelled behavior that must not start now; None if it may."""
    for overriding in place.services.overriding:
        plan = overriding.plan
        if plan.mode is OverrideMode.ON_START or not _is(overriding, plan.overridden, place.instance, label):
            continue
        if _running(overriding.instance, plan.by) is not None:
            return replace(_outcome(plan), has_begun=False)
    return None


def start_labelled(label: str, place: Place, scope: Scope) -> None:
    """A labelled behavior starts: what it overrides ends, between this round and the next."""
    running = place.instance.running
    place.agenda.write(place.position, partial(running.__setitem__, label, scope))
    place.agenda.after_round(place.position, partial(_end_overridden, label, place, scope))


def end_labelled(label: str, place: Place, scope: Scope) -> None:
    """A labelled behavior has ended; that takes hold between this round and the next."""

    def take_hold() -> None:
        if place.instance.running.get(label) is scope:
            del place.instance.running[label]

    place.agenda.write(place.position, take_hold)


def _end_overridden(label: str, place: Place, scope: Scope) -> None:
    if place.agenda.is_ended(scope):
        return  # by one that started in the same round
    for overriding in tuple(place.services.overriding):
        if _is(overriding, overriding.plan.by, place.instance, label):
            overridden = _running(overriding.instance, overriding.plan.overridden)
            if overridden is not None and overridden is not scope:
                place.agenda.end(overridden, _outcome(overriding.plan))


def _outcome(plan: Override) -> Outcome:
    return Outcome(Status.CANCELLED, f"overridden by `{'.'.join(plan.by)}`", plan.span)


def _holder(instance: Instance, path: LabelPath) -> Instance | None:
    """The instance in which the last label of a path stands."""
    holder: Instance | None = instance
    for label in path[:-1]:
        holder = holder.latest(label).instance if holder is not None else None
    return holder


def _is(overriding: Overriding, path: LabelPath, instance: Instance, label: str) -> bool:
    """Whether a path leads to a behavior."""
    return path[-1] == label and _holder(overriding.instance, path) is instance


def _running(instance: Instance, path: LabelPath) -> Scope | None:
    """The behavior that a path leads to, if it runs."""
    holder = _holder(instance, path)
    return holder.running.get(path[-1]) if holder is not None else None
