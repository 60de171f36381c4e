"""What lies around a behavior, the outermost first: `until`, modifiers, overrides, and its duration.

Directives `until` that stand in a row are one, which any of their events meets (7.6.2.5.4).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

from seoro.lang.plan import (
    Behavior,
    CallMethod,
    Emit,
    Expression,
    InvokeAction,
    InvokeScenario,
    Modification,
    ModifierApplication,
    Override,
    Plan,
    Until,
    Wait,
)


@dataclass(frozen=True)
class Untils:
    """Directives `until` that stand in a row."""

    directives: tuple[Until, ...]


@dataclass(frozen=True)
class Duration:
    """How long it lasts."""

    expression: Expression


Layer: TypeAlias = Untils | ModifierApplication | Override | Duration


def layers_of(behavior: Behavior, plan: Plan) -> tuple[Layer, ...]:
    """The layers of a behavior."""
    match behavior:
        case Wait() | Emit() | CallMethod():
            return ()
        case InvokeScenario(scenario=name):
            own = layers_in(plan.scenarios[name].modifiers)
        case InvokeAction(action=name):
            own = layers_in(plan.actions[name].modifiers)
        case _:
            own = ()
    duration = (Duration(behavior.duration),) if behavior.duration is not None else ()
    return (*layers_in(behavior.modifications), *duration, *own)


def layers_in(modifications: Iterable[Modification]) -> tuple[Layer, ...]:
    """The layers of what stands in a `with` block, or in a declaration."""
    layers: list[Layer] = []
    row: list[Until] = []
    for modification in modifications:
        if isinstance(modification, Until):
            row.append(modification)
            continue
        if row:
            layers.append(Untils(tuple(row)))
            row = []
        layers.append(modification)
    if row:
        layers.append(Untils(tuple(row)))
    return tuple(layers)
