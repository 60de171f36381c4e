"""A failure planted in a space, to compare strategies: 0.26 % of it fails, and 3 of 6 parameters matter."""

from __future__ import annotations

import math
from collections.abc import Iterator
from random import Random
from typing import Final

from seoro.campaign.runs import End, Point, Row
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Strategy, Told
from tests.campaign.spaces import ranged

SPACE: Final = Space(tuple(ranged(f"p{number}") for number in range(6)))
SHARE: Final = 0.0026  # of the space that fails
RADIUS: Final = (SHARE * 3 / (4 * math.pi)) ** (1 / 3)  # of the ball that fails
COLUMN: Final = "robot.distance"


class Planted:
    """Ball of failures within the first three parameters; the distance from it has a ripple in all six.

    Args:
        seed: Seed of its place.
    """

    def __init__(self, seed: int) -> None:
        random = Random(f"planted {seed}")  # independent of the draws of strategies
        self._centre = [random.uniform(0.1, 0.9) for _ in range(3)]
        self._phases = [random.uniform(0.0, math.tau) for _ in SPACE.axes]

    def told(self, point: Point) -> Told:
        """Return the result of a run."""
        values = [float(text) for text in point.values.values()]
        distance = math.dist(values[:3], self._centre) - RADIUS
        ripple = sum(1 + math.sin(9 * value + phase) for value, phase in zip(values, self._phases, strict=True))
        status = End.FAILED if distance < 0 else End.PASSED
        return Told(point, (Row(1, "", 1, 1, 1, status, measured={COLUMN: distance * (1 + ripple / 6)}),))


def results(strategy: Strategy, planted: Planted, seed: int) -> Iterator[Told]:
    """Yield the results of the points of a strategy."""
    batches = strategy.batches(SPACE, seed)
    points = next(batches)
    while True:
        told = [planted.told(point) for point in points]
        yield from told
        points = batches.send(told)


def runs_until_failure(strategy: Strategy, planted: Planted, seed: int, most: int) -> int:
    """Return the number of runs to the first failure; `most + 1` without one within `most`."""
    for number, told in enumerate(results(strategy, planted, seed), 1):
        if number > most or told.rows[0].status is End.FAILED:
            return number
    raise AssertionError("the strategy ends")
