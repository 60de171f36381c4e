"""Search for failures by the cross-entropy method, in pure Python.

Each batch is drawn from a distribution of each axis, which then moves to the best points so far (Rubinstein, "The
cross-entropy method for combinatorial and continuous optimization", 1999). The first batch is a Latin hypercube.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random
from typing import ClassVar, Final

from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.campaign.strategies.distributions import Distribution, Normal, Weights
from seoro.campaign.strategies.objective import MAXIMIZE, MINIMIZE, Objective, objective_of
from seoro.campaign.strategies.shares import TRIES, Shares, hypercube, point_at
from seoro.errors import UsageError
from seoro.lang.frozen import Value

BATCH: Final = 20  # points between two lessons
ELITE: Final = 5  # best points that the distributions move to
EXPLORED: Final = 0.1  # of a batch, drawn uniformly, to leave a local minimum


class Search(Value):
    """Search for the least or largest value of a column; failed runs have the best of all.

    Args:
        minimize: Column that is small near failures; empty for `margin`.
        maximize: Column that is large near failures, instead.
    """

    minimize: str = ""
    maximize: str = ""
    name = "search"
    is_learning = True
    is_endless = True
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {"minimize": MINIMIZE, "maximize": MAXIMIZE}

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches; see `Strategy`."""
        if not space.axes:
            raise UsageError("a search needs a parameter that varies")
        return self._batches(space, objective_of(self.minimize, self.maximize), Random(seed))  # noqa: S311

    def _batches(self, space: Space, objective: Objective, random: Random) -> Batches:
        known: list[tuple[float, Shares]] = []
        is_known = False
        distributions = [_distribution(axis) for axis in space.axes]
        drawn = list(hypercube(BATCH, len(space.axes), random))
        while True:
            told = yield [point_at(space.axes, shares) for shares in drawn]
            values = [objective.value(each) for each in told]
            known += [(value, shares) for value, shares in zip(values, drawn, strict=True) if value is not None]
            is_known = is_known or objective.is_known(told)
            known = sorted(known, key=lambda each: each[0])[:ELITE]
            if len(known) == ELITE:
                for index, distribution in enumerate(distributions):
                    distribution.learn([shares[index] for _, shares in known])
            drawn = [_draw(distributions, space, random) for _ in range(BATCH)]


def _distribution(axis: Axis) -> Distribution:
    if isinstance(axis, Choices) and not axis.is_ascending:
        return Weights(len(axis.texts))
    return Normal()


def _draw(distributions: Sequence[Distribution], space: Space, random: Random) -> Shares:
    """Draw a point that constraints allow."""
    is_explored = random.random() < EXPLORED
    for _ in range(TRIES):
        shares = tuple(random.random() if is_explored else each.draw(random) for each in distributions)
        if space.is_feasible(point_at(space.axes, shares).values):
            break
    return shares
