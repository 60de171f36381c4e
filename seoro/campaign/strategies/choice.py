"""Strategies by name, and their options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any, Final

from seoro.campaign.store.folder import StrategyText
from seoro.campaign.strategies.boundary import Boundary
from seoro.campaign.strategies.contract import Strategy
from seoro.campaign.strategies.cover import Cover
from seoro.campaign.strategies.grid import Grid
from seoro.campaign.strategies.latin import Latin
from seoro.campaign.strategies.map_elites import MapElites
from seoro.campaign.strategies.optimizers import CmaEs, Tpe
from seoro.campaign.strategies.pairwise import Pairwise
from seoro.campaign.strategies.random import Uniform
from seoro.campaign.strategies.search import Search
from seoro.campaign.strategies.sobol import Sobol
from seoro.errors import UsageError
from seoro.lang.diagnostics import near
from seoro.lang.frozen import Value

_ALL: Final[tuple[type[Any], ...]] = (
    Grid,
    Uniform,
    Latin,
    Sobol,
    Pairwise,
    Boundary,
    Cover,
    Search,
    Tpe,
    CmaEs,
    MapElites,
)
STRATEGIES: Final[Mapping[str, type[Any]]] = {each.name: each for each in _ALL}
"""Classes of strategies; their fields are their options."""


AFTERWARDS: Final = ("shrink", "neighbours")
"""Strategies that begin at a failed run of another campaign."""


class StrategyOption(Value):
    """Option of strategies.

    Args:
        name: Name of the field.
        kind: Type of its values.
        help: Description.
        strategies: Names of the strategies that have it.
    """

    name: str
    kind: type[int | float | str | bool]
    help: str
    strategies: tuple[str, ...]


def strategy_options() -> tuple[StrategyOption, ...]:
    """Return the options of all strategies; equal fields of several are one."""
    found: dict[str, StrategyOption] = {}
    for name, kind in STRATEGIES.items():
        for each in fields(kind):
            assert each.default is not MISSING, "options have defaults"
            before = found[each.name].strategies if each.name in found else ()
            found[each.name] = StrategyOption(
                each.name, type(each.default), kind.helps[each.name], (*before, name)
            )
    return tuple(found.values())


def make_strategy(text: StrategyText) -> Strategy:
    """Make a strategy from its name and its options.

    Raises:
        UsageError: The name or an option is unknown, or a value has the wrong type.
    """
    if text.name in AFTERWARDS:
        raise UsageError(
            f"this campaign is part of another one; `seoro campaign {text.name}` continues it",
            help=f"seoro campaign {text.name} FOLDER RUN, with the folder and the number of the failed run",
        )
    kind = STRATEGIES.get(text.name)
    if kind is None:
        hint = near(text.name, STRATEGIES) or f"strategies: {', '.join(STRATEGIES)}"
        raise UsageError(f"unknown strategy `{text.name}`", help=hint)
    known = {each.name: type(each.default) for each in fields(kind)}
    for name, value in text.options.items():
        if name not in known:
            options = ", ".join(f"`--{each}`" for each in known) or "none"
            message = f"`--{name}` has no effect with the strategy `{text.name}`"
            raise UsageError(message, help=f"its options: {options}")
        if type(value) is not known[name]:
            raise UsageError(f"expected {known[name].__name__} for `{name}`, found {value!r}")
    strategy: Strategy = kind(**text.options)
    return strategy


def text_of(strategy: Strategy) -> StrategyText:
    """Return the name and the options of a strategy, for `campaign.json`."""
    options = {each.name: getattr(strategy, each.name) for each in fields(strategy)}  # type: ignore[arg-type]
    return StrategyText(name=strategy.name, options=options)
