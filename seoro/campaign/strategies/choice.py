"""Strategies by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Final

from seoro.campaign.store.folder import StrategyText
from seoro.campaign.strategies.contract import Strategy
from seoro.campaign.strategies.grid import Grid
from seoro.campaign.strategies.random import Uniform
from seoro.errors import UsageError
from seoro.lang.diagnostics import near

STRATEGIES: Final[Mapping[str, Callable[..., Strategy]]] = {each.name: each for each in (Grid, Uniform)}
"""Classes of strategies; their fields are their options."""


def make_strategy(text: StrategyText) -> Strategy:
    """Make a strategy from its name and its options.

    Raises:
        UsageError: The name or an option is unknown.
    """
    kind = STRATEGIES.get(text.name)
    if kind is None:
        hint = near(text.name, STRATEGIES) or f"strategies: {', '.join(STRATEGIES)}"
        raise UsageError(f"unknown strategy `{text.name}`", help=hint)
    return kind(**text.options)


def text_of(strategy: Strategy) -> StrategyText:
    """Return the name and the options of a strategy, for `campaign.json`."""
    options = {each.name: getattr(strategy, each.name) for each in fields(strategy)}  # type: ignore[arg-type]
    return StrategyText(name=strategy.name, options=options)
