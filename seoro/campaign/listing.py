"""Planned runs that constraints allow, without a run and without a folder."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.campaign.opening import Asked
from seoro.campaign.planner import MOST_IMPOSSIBLE, runs_of
from seoro.campaign.runs import Planned, Point
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Strategy
from seoro.errors import UsageError


def possible_runs(space: Space, asked: Asked) -> Iterator[Planned]:
    """Yield the runs of a campaign that constraints allow, lazily, up to the wanted number.

    Of a strategy that learns, they are those of the first batch.

    Args:
        space: Axes of the campaign, and their constraints.
        asked: The request.

    Raises:
        UsageError: The strategy cannot be used with these axes, or no run is possible.
    """
    possible = excluded = 0
    for variant, point in enumerate(_points(asked.strategy, space, asked.seed), start=1):
        if space.is_feasible(point.values):
            for run in runs_of(point, variant, asked.strategy, asked.seed, asked.repeat, asked.seeds):
                if possible == asked.runs:
                    return
                possible += 1
                yield run
        else:
            excluded += 1
        if not possible and excluded >= MOST_IMPOSSIBLE:
            break
    if not possible:
        raise UsageError(f"the constraints of the scenario exclude all of the first {excluded} runs")


def _points(strategy: Strategy, space: Space, seed: int) -> Iterator[Point]:
    for batch in strategy.batches(space, seed):
        yield from batch
        if strategy.is_learning:
            return
