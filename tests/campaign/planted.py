"""Failures planted in a space of six parameters, to compare strategies."""

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
COLUMN: Final = "robot.distance"


class Failures:
    """Balls of failures, each within three parameters; the distance from the nearest has a ripple in all six.

    Args:
        seed: Seed of their places.
        balls: Number of balls.
        share: Share of the space that fails, if the balls are apart.
    """

    def __init__(self, seed: int, balls: int, share: float) -> None:
        random = Random(f"planted {seed}")  # independent of the draws of strategies
        self._radius = (share / balls * 3 / (4 * math.pi)) ** (1 / 3)
        self._centres = [[random.uniform(0.1, 0.9) for _ in range(3)] for _ in range(balls)]
        self._phases = [random.uniform(0.0, math.tau) for _ in SPACE.axes]

    def told(self, point: Point) -> Told:
        """Return the result of a run."""
        values = [float(text) for text in point.values.values()]
        distance = min(
            math.dist(values[number : number + 3], centre) for number, centre in enumerate(self._centres)
        )
        distance -= self._radius
        ripple = sum(1 + math.sin(9 * value + phase) for value, phase in zip(values, self._phases, strict=True))
        status = End.FAILED if distance < 0 else End.PASSED
        return Told(point, (Row(1, "", 1, 1, 1, status, measured={COLUMN: distance * (1 + ripple / 6)}),))


def in_one_place(seed: int) -> Failures:
    """Return one ball; 0.26 % of the space fails, and three parameters matter."""
    return Failures(seed, 1, 0.0026)


def in_four_places(seed: int) -> Failures:
    """Return four balls, which different parameters matter for; 1.25 % of the space fails."""
    return Failures(seed, 4, 0.0125)


def results(strategy: Strategy, failures: Failures, seed: int) -> Iterator[Told]:
    """Yield the results of the points of a strategy."""
    batches = strategy.batches(SPACE, seed)
    points = next(batches)
    while True:
        told = [failures.told(point) for point in points]
        yield from told
        points = batches.send(told)


def runs_until_failure(strategy: Strategy, failures: Failures, seed: int, most: int) -> int:
    """Return the number of runs to the first failure; `most + 1` without one within `most`."""
    for number, told in enumerate(results(strategy, failures, seed), 1):
        if number > most or told.rows[0].status is End.FAILED:
            return number
    raise AssertionError("the strategy ends")
