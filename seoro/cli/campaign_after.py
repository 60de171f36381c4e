"""Subcommands of `seoro campaign` that begin at runs of a campaign."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from typing import Final

from seoro.campaign.store.folder import NEIGHBOURS, SHRINK
from seoro.cli.arguments import Commands
from seoro.cli.campaign_neighbours import add_neighbours, neighbours
from seoro.cli.campaign_rank import RANK, add_rank, rank
from seoro.cli.campaign_replay import add_replay, replay
from seoro.cli.campaign_shrink import add_shrink, shrink

AFTER: Final[Mapping[str, Callable[[argparse.Namespace], int]]] = {
    "replay": replay,
    SHRINK: shrink,
    NEIGHBOURS: neighbours,
    RANK: rank,
}
"""Functions that run the subcommands, by name."""


def add_after(commands: Commands) -> None:
    """Declare the subcommands."""
    for add in (add_replay, add_shrink, add_neighbours, add_rank):
        add(commands)
