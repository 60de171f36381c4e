"""Invocations of the entry scenario by name, so that what is given from outside can reach their parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from seoro.lang import plan
from seoro.lang.lower import reach

Invocation = plan.InvokeAction | plan.InvokeScenario


def named_invocations(body: plan.Behavior | None) -> Mapping[str, Invocation]:
    """The invocations of a scenario's `do`, in the order of the text, by their names.

    That is the label, else the name of what is invoked, without its actor; where several have none but this, the
    first is `name[0]`, the second `name[1]`.
    """
    found = list(reach.invocations(body))
    names = [each.label or _called(each) for each in found]
    total, seen = Counter(names), Counter[str]()
    named: dict[str, Invocation] = {}
    for name, each in zip(names, found, strict=True):
        named[name if total[name] == 1 else f"{name}[{seen[name]}]"] = each
        seen[name] += 1
    return named


def called(invocation: Invocation) -> str:
    """The name of what is invoked, in the plan."""
    return invocation.action if isinstance(invocation, plan.InvokeAction) else invocation.scenario


def _called(invocation: Invocation) -> str:
    return called(invocation).rpartition(".")[2].rpartition("::")[2]


def constrained(behavior: plan.Behavior, added: Mapping[Invocation, Sequence[plan.Constraint]]) -> plan.Behavior:
    """A behavior with more constraints on some of its invocations."""
    match behavior:
        case plan.Serial() | plan.Parallel() | plan.OneOf():
            return replace(behavior, members=tuple(constrained(each, added) for each in behavior.members))
        case plan.InvokeAction() | plan.InvokeScenario() if behavior in added:
            return replace(behavior, constraints=(*behavior.constraints, *added[behavior]))
        case _:
            return behavior
