"""Invocations of the entry scenario by name, for overrides of their parameters; applied modifiers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from seoro.lang import plan

Invocation = plan.InvokeAction | plan.InvokeScenario


def named_invocations(body: plan.Behavior | None) -> Mapping[str, Invocation]:
    """Return the invocations in the `do` of a scenario by name, in source order.

    The name is the label, else the name of the invoked behavior, without its actor. Equal names get a number:
    `name[0]`, `name[1]`.
    """
    found = list(plan.invocations_in(body))
    names = [each.label or _bare_name(each) for each in found]
    total, seen = Counter(names), Counter[str]()
    named: dict[str, Invocation] = {}
    for name, each in zip(names, found, strict=True):
        named[name if total[name] == 1 else f"{name}[{seen[name]}]"] = each
        seen[name] += 1
    return named


def invoked_name(invocation: Invocation) -> str:
    """Return the name of the invoked behavior in the plan."""
    return invocation.action if isinstance(invocation, plan.InvokeAction) else invocation.scenario


def _bare_name(invocation: Invocation) -> str:
    return invoked_name(invocation).rpartition(".")[2].rpartition("::")[2]


def constrained(behavior: plan.Behavior, added: Mapping[Invocation, Sequence[plan.Constraint]]) -> plan.Behavior:
    """Copy a behavior with additional constraints on some of its invocations."""
    match behavior:
        case plan.Composition():
            return replace(behavior, members=tuple(constrained(each, added) for each in behavior.members))
        case plan.Invocation() if behavior in added:
            return replace(behavior, constraints=(*behavior.constraints, *added[behavior]))
        case _:
            return behavior


def applied_in(body: plan.Behavior | None) -> Iterator[str]:
    """Yield the names of all modifiers that are applied in a behavior."""
    for behavior in plan.behaviors_in(body):
        if isinstance(behavior, plan.Composition | plan.Invocation):
            yield from applied(behavior.modifications)


def applied(modifications: Iterable[plan.Modification]) -> Iterator[str]:
    """Yield the names of the modifiers among modifications."""
    return (each.modifier for each in modifications if isinstance(each, plan.ModifierApplication))
