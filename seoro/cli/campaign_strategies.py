"""Options of `seoro campaign run` for strategies."""

from __future__ import annotations

import argparse
import math

from seoro.campaign.store.folder import StrategyText
from seoro.campaign.strategies.choice import STRATEGIES, make_strategy, strategy_options
from seoro.campaign.strategies.contract import Strategy
from seoro.campaign.strategies.grid import Grid
from seoro.campaign.strategies.latin import Latin
from seoro.cli.arguments import Container, add_option

_PLACEHOLDERS = {int: " N", str: " NAME", bool: ""}


def add_strategies(parser: Container) -> None:
    """Declare `--strategy`, and an option for each field of strategies."""
    add_option(
        parser,
        "--strategy NAME",
        f"choice of values: {', '.join(STRATEGIES)} (default: grid)",
        default=None,
    )
    for each in strategy_options():
        spec = f"--{each.name}{_PLACEHOLDERS[each.kind]}"
        add_option(parser, spec, f"with {' and '.join(each.strategies)}: {each.help}", default=None)


def chosen_strategy(options: argparse.Namespace) -> Strategy:
    """Make the strategy that the options ask for.

    Raises:
        UsageError: It is unknown, or an option belongs to another one.
    """
    given = {each.name: getattr(options, each.name) for each in strategy_options()}
    given = {name: value for name, value in given.items() if value is not None}
    name = options.strategy or Grid.name
    if name == Latin.name and options.runs is not None:
        given.setdefault("size", math.ceil(options.runs / options.repeat))
    return make_strategy(StrategyText(name=name, options=given))
