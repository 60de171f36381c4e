"""Traversal of behaviors of the plan: their invocations, and the applied modifiers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import assert_never

from seoro.lang import plan


def invocations(body: plan.Behavior | None) -> Iterator[plan.InvokeAction | plan.InvokeScenario]:
    """Yield all invocations in a behavior, in source order."""
    for behavior in walk(body):
        if isinstance(behavior, plan.InvokeAction | plan.InvokeScenario):
            yield behavior


def modifiers(body: plan.Behavior | None) -> Iterator[str]:
    """Yield the names of all modifiers that are applied in a behavior."""
    for behavior in walk(body):
        match behavior:
            case plan.Wait() | plan.Emit() | plan.CallMethod():
                pass
            case _:
                yield from _names(behavior.modifications)


def applied(holder: plan.Scenario | plan.Action | plan.Modifier | plan.ObjectType) -> Iterator[str]:
    """Yield the names of the modifiers among the members of a declaration."""
    yield from _names(holder.modifiers)


def _names(modifications: Iterable[plan.Modification]) -> Iterator[str]:
    for modification in modifications:
        if isinstance(modification, plan.ModifierApplication):
            yield modification.modifier


def walk(body: plan.Behavior | None) -> Iterator[plan.Behavior]:
    """Yield a behavior and its descendants in source order."""
    stack = [body] if body is not None else []
    while stack:
        behavior = stack.pop()
        yield behavior
        match behavior:
            case plan.Composition():
                stack += reversed(behavior.members)
            case plan.Invocation() | plan.Wait() | plan.Emit() | plan.CallMethod():
                pass
            case _:
                assert_never(behavior)
