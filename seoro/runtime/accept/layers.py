"""Layers around a behavior, the outermost first: `until`, modifiers, overrides, and its duration.

Adjacent directives `until` form one layer, which any of their events meets (7.6.2.5.4).

Constraints may bound the times of a behavior: `duration`, `overlap` and offsets of `it` (7.3.13).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Final, TypeAlias, cast

from seoro.lang import plan as plan_
from seoro.lang.source import Span

_TIMES: Final = frozenset({"duration", "overlap", "start_to_start", "end_to_end"})


def times_in(expression: plan_.Expression) -> frozenset[str]:
    """Return the times of `it` in an expression."""
    return frozenset(cast(plan_.Member, part).name for part in plan_.walk(expression) if is_time(part))


def has_times(behavior: plan_.Behavior | None, applied: Iterable[object], plan: plan_.Plan) -> bool:
    """Whether constraints affect times of a behavior: its own, those of its modifiers, or of held objects."""
    members: list[object] = list(getattr(behavior, "constraints", ()))
    held = (each for type_ in plan.objects.values() for each in type_.modifiers)
    pending = [each for each in chain(applied, held) if isinstance(each, plan_.ModifierApplication)]
    while pending:
        modifier = plan.modifiers[pending.pop().modifier]
        members += modifier.structure.members
        pending += [each for each in modifier.modifiers if isinstance(each, plan_.ModifierApplication)]
    return any(times_in(expression) for expression in expressions_of(members))


def expressions_of(members: Iterable[object]) -> Iterator[plan_.Expression]:
    """Yield the conditions and defaults among members of a declaration."""
    for member in members:
        if isinstance(member, plan_.Constraint):
            yield member.condition
        elif isinstance(member, plan_.FieldDeclaration) and member.default is not None:
            yield member.default


def is_time(expression: plan_.Expression) -> bool:
    """Whether an expression is a time of `it`."""
    return (
        isinstance(expression, plan_.Member)
        and expression.name in _TIMES
        and isinstance(expression.base, plan_.Binding)
        and expression.base.name == "it"
    )


@dataclass(frozen=True)
class Untils:
    """Adjacent directives `until`."""

    directives: tuple[plan_.Until, ...]


@dataclass(frozen=True)
class Duration:
    """Duration of a behavior.

    Args:
        expression: Argument, or None.
        behavior: Behavior whose constraints may bound it; None for the run itself.
    """

    expression: plan_.Expression | None
    behavior: plan_.Behavior | None
    span: Span


Layer: TypeAlias = Untils | plan_.ModifierApplication | plan_.Override | Duration


def layers_of(behavior: plan_.Behavior, plan: plan_.Plan) -> tuple[Layer, ...]:
    """Return the layers of a behavior."""
    match behavior:
        case plan_.Wait() | plan_.Emit() | plan_.CallMethod():
            return ()
        case plan_.InvokeScenario(scenario=name):
            own = layers_in(plan.scenarios[name].modifiers)
        case plan_.InvokeAction(action=name):
            own = layers_in(plan.actions[name].modifiers)
        case _:
            own = ()
    outer = layers_in(behavior.modifications)
    if behavior.duration is not None:
        return (*outer, Duration(behavior.duration, behavior, behavior.duration.span), *own)
    if has_times(behavior, (*outer, *own), plan):
        return (*outer, Duration(None, behavior, behavior.span), *own)
    return (*outer, *own)


def layers_of_run(plan: plan_.Plan) -> tuple[Layer, ...]:
    """Return the layers of the run itself."""
    declared = plan.scenarios[plan.entry]
    own = layers_in(declared.modifiers)
    return (*own, Duration(None, None, declared.span)) if has_times(None, own, plan) else own


def layers_in(modifications: Iterable[plan_.Modification]) -> tuple[Layer, ...]:
    """Return the layers of a `with` block or a declaration."""
    layers: list[Layer] = []
    for modification in modifications:
        if not isinstance(modification, plan_.Until):
            layers.append(modification)
        elif layers and isinstance(layers[-1], Untils):
            layers[-1] = Untils((*layers[-1].directives, modification))
        else:
            layers.append(Untils((modification,)))
    return tuple(layers)


def overrides_in(plan: plan_.Plan) -> list[plan_.Override]:
    """Return all overrides of a plan."""
    found: list[object] = [each for modifier in plan.modifiers.values() for each in modifier.modifiers]
    for scenario in plan.scenarios.values():
        found += scenario.modifiers
        for behavior in plan_.behaviors_in(scenario.body):
            found += getattr(behavior, "modifications", ())
    return [each for each in found if isinstance(each, plan_.Override)]
