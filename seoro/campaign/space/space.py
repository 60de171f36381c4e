"""Space of a campaign: axes, their usual values, and constraints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field

from seoro.campaign.coverage.drawing import InputSpace
from seoro.campaign.space.axes import Axis
from seoro.campaign.store.covered import CoveredItem
from seoro.lang.frozen import Value


def _allow_all(_values: Mapping[str, str]) -> bool:
    return True


class Space(Value):
    """Space of a campaign.

    Args:
        axes: Parameters that vary.
        usual: Default values of some of them, by path.
        is_feasible: Returns whether constraints allow values of some parameters, with some values of the others.
        inputs: Bins of `cover` items over parameters, and values for them; None without.
        items: Definitions of all `cover` items.
    """

    axes: tuple[Axis, ...] = ()
    usual: Mapping[str, str] = field(default_factory=dict)
    is_feasible: Callable[[Mapping[str, str]], bool] = _allow_all
    inputs: InputSpace | None = None
    items: tuple[CoveredItem, ...] = ()
