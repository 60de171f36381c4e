"""Search for failures, in pure Python: half of each batch by the cross-entropy method, half by Parzen estimators.

The cross-entropy method draws from one distribution of each axis, which moves to the best points so far
(Rubinstein, "The cross-entropy method for combinatorial and continuous optimization", 1999). It is fast where
failures are in one place. Estimators around single points (`parzen.py`) find failures in several places. The first
batch is a Latin hypercube.
"""

from __future__ import annotations

import math
from bisect import insort
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from operator import itemgetter
from random import Random
from typing import ClassVar, Final

from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.campaign.strategies.distributions import Distribution, Normal, Weights
from seoro.campaign.strategies.objective import MAXIMIZE, MINIMIZE, Objective, objective_of
from seoro.campaign.strategies.parzen import CANDIDATES, densities, draw_likely
from seoro.campaign.strategies.shares import TRIES, Shares, hypercube, point_at
from seoro.errors import UsageError
from seoro.lang.frozen import Value

FIRST: Final = 10  # points before the first lesson
BATCH: Final = 8  # points between two lessons
ELITE: Final = 5  # best points that distributions move to, and that are good at least
GOOD: Final = 0.15  # share of the points that are good
MOST_GOOD: Final = 25
MOST_OTHERS: Final = 200  # the newest; the time for a draw grows with them
EXPLORED: Final = 0.1  # of the draws from distributions, uniform ones, to leave a local minimum


class Search(Value):
    """Search for the least or largest value of a column; failed runs have the best of all.

    Args:
        minimize: Column that is small near failures; empty for `margin`.
        maximize: Column that is large near failures, instead.
        batch: Number of points between two lessons.
    """

    minimize: str = ""
    maximize: str = ""
    batch: int = BATCH
    name = "search"
    is_learning = True
    is_endless = True
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {
        "minimize": MINIMIZE,
        "maximize": MAXIMIZE,
        "batch": f"number of points between two lessons (default: {BATCH})",
    }

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches; see `Strategy`."""
        if not space.axes:
            raise UsageError("a search needs a parameter that varies")
        if self.batch < 1:
            raise UsageError(f"expected at least 1 for `batch`, found {self.batch}")
        return self._batches(space, objective_of(self.minimize, self.maximize), Random(seed))  # noqa: S311

    def _batches(self, space: Space, objective: Objective, random: Random) -> Batches:
        known, is_known = _Known(), False
        distributions = [_distribution(axis) for axis in space.axes]
        drawn = list(hypercube(max(FIRST, self.batch), len(space.axes), random))
        while True:
            told = yield [point_at(space.axes, shares) for shares in drawn]
            for shares, each in zip(drawn, told, strict=True):
                known.add(objective.value(each), shares)
            is_known = is_known or objective.is_known(told)
            elite = known.elite
            if len(elite) == ELITE:
                for index, distribution in enumerate(distributions):
                    distribution.learn([shares[index] for shares in elite])
            drawn = [_draw(distributions, space, random) for _ in range(math.ceil(self.batch / 2))]
            while len(drawn) < self.batch:
                drawn.append(_draw_likely(known, drawn, space, random))


class _Known:
    """Points with their values: the best, and the newest of the others."""

    def __init__(self) -> None:
        self._best: list[tuple[float, Shares]] = []
        self._others: deque[Shares] = deque(maxlen=MOST_OTHERS)
        self._count = 0

    def add(self, value: float | None, shares: Shares) -> None:
        """Add a point; one without a value is among the others."""
        self._count += 1
        if value is None:
            self._others.append(shares)
            return
        insort(self._best, (value, shares), key=itemgetter(0))
        if len(self._best) > MOST_GOOD:
            self._others.append(self._best.pop()[1])

    @property
    def elite(self) -> list[Shares]:
        """The best points, at most `ELITE`."""
        return [shares for _, shares in self._best[:ELITE]]

    def divided(self) -> tuple[list[Shares], list[Shares]]:
        """Return the good points, and the others; either may be empty."""
        number = max(ELITE, math.ceil(GOOD * self._count))
        points = [shares for _, shares in self._best]
        return points[:number], [*points[number:], *self._others]


def _distribution(axis: Axis) -> Distribution:
    size = _size(axis)
    return Normal() if size is None else Weights(size)


def _size(axis: Axis) -> int | None:
    """Return the number of values of an axis without order; None for others."""
    return len(axis.texts) if isinstance(axis, Choices) and not axis.is_ascending else None


def _draw(distributions: Sequence[Distribution], space: Space, random: Random) -> Shares:
    """Draw a point that constraints allow."""
    is_explored = random.random() < EXPLORED
    for _ in range(TRIES):
        shares = tuple(random.random() if is_explored else each.draw(random) for each in distributions)
        if space.is_feasible(point_at(space.axes, shares).values):
            break
    return shares


def _draw_likely(known: _Known, pending: Sequence[Shares], space: Space, random: Random) -> Shares:
    """Draw a point that constraints allow, where points are good and others few, also pending ones."""
    for shares in _likely(known, pending, space, random):
        if space.is_feasible(point_at(space.axes, shares).values):
            break
    return shares


def _likely(known: _Known, pending: Sequence[Shares], space: Space, random: Random) -> Iterator[Shares]:
    """Yield draws; uniform ones before there are good and other points."""
    good, others = known.divided()
    if not good:
        yield from (tuple(random.random() for _ in space.axes) for _ in range(TRIES))
        return
    sizes = [_size(axis) for axis in space.axes]
    likely, unlikely = densities(good, sizes), densities([*others, *pending], sizes)
    for _ in range(TRIES // CANDIDATES):
        yield from draw_likely(likely, unlikely, random)
