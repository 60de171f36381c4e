"""Layers around a behavior, the outermost first: `until`, modifiers, overrides, and its duration.

Adjacent directives `until` form one layer, which any of their events meets (7.6.2.5.4).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

from seoro.lang import plan as plan_
from seoro.lang.source import Span
from seoro.runtime.accept.constrained_times import has_times


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
    row: list[plan_.Until] = []
    for modification in modifications:
        if isinstance(modification, plan_.Until):
            row.append(modification)
            continue
        if row:
            layers.append(Untils(tuple(row)))
            row = []
        layers.append(modification)
    if row:
        layers.append(Untils(tuple(row)))
    return tuple(layers)
