"""What a behavior of the plan reaches: what it invokes, and the modifiers that it applies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import assert_never

from seoro.lang import plan


def invocations(body: plan.Behavior | None) -> Iterator[plan.InvokeAction | plan.InvokeScenario]:
    """All invocations in a behavior, in the order of the text."""
    for behavior in _all(body):
        if isinstance(behavior, plan.InvokeAction | plan.InvokeScenario):
            yield behavior


def modifiers(body: plan.Behavior | None) -> Iterator[str]:
    """The names of all modifiers that are applied in a behavior."""
    for behavior in _all(body):
        match behavior:
            case plan.Wait() | plan.Emit() | plan.CallMethod():
                pass
            case _:
                yield from _names(behavior.modifications)


def applied(holder: plan.Scenario | plan.Action | plan.Modifier | plan.ObjectType) -> Iterator[str]:
    """The names of the modifiers that are members of a declaration."""
    yield from _names(holder.modifiers)


def _names(modifications: Iterable[plan.Modification]) -> Iterator[str]:
    for modification in modifications:
        if isinstance(modification, plan.ModifierApplication):
            yield modification.modifier


def _all(body: plan.Behavior | None) -> Iterator[plan.Behavior]:
    """A behavior and all in it, in the order of the text."""
    stack = [body] if body is not None else []
    while stack:
        behavior = stack.pop()
        yield behavior
        match behavior:
            case plan.Serial() | plan.Parallel() | plan.OneOf():
                stack += reversed(behavior.members)
            case plan.InvokeAction() | plan.InvokeScenario() | plan.Wait() | plan.Emit() | plan.CallMethod():
                pass
            case _:
                assert_never(behavior)
