"""Values of planned runs, without a run and without a folder."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.campaign.planner import MOST_IMPOSSIBLE
from seoro.campaign.runs import Point
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Strategy
from seoro.errors import UsageError


def possible_points(space: Space, strategy: Strategy, seed: int) -> Iterator[Point]:
    """Yield the points of a strategy that constraints allow, lazily; of one that learns, those of the first batch.

    Args:
        space: Axes of the campaign, and their constraints.
        strategy: Chooses the values.
        seed: Seed of the strategy.

    Raises:
        UsageError: The strategy cannot be used with these axes, or no point is possible.
    """
    possible = excluded = 0
    for point in _points(strategy, space, seed):
        if space.is_feasible(point.values):
            possible += 1
            yield point
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
