"""Planted failures for strategies that begin at a failed run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from random import Random
from typing import Final

from seoro.campaign.after.same_failure import SameFailure
from seoro.campaign.runs import End, Point, Row
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Strategy, Told
from tests.campaign.spaces import listed, ranged

FAILURE: Final = SameFailure("too late", "main.osc:9:5")
SPACE: Final = Space(
    (
        ranged("a", 0, 100, is_whole=True),
        ranged("load"),
        ranged("slope", -1, 1),
        listed("mode", 5),
        ranged("gap", 0.4, 0.9),
    ),
    usual={"mode": "2"},
)
"""Five parameters, of which the first two decide about planted failures."""
SIMPLE: Final = {"slope": "0.0", "mode": "2", "gap": "0.4"}

Fails = Callable[[Mapping[str, str]], bool]


def planted(seed: int) -> tuple[Fails, dict[str, str]]:
    """Return a failure in `SPACE`, and a point that fails.

    Args:
        seed: Seeds divisible by three are limits for each of two parameters, those after it a limit for their sum,
            and those after these a small box.
    """
    random = Random(f"shrunk {seed}")
    a, load = random.randint(1, 90), random.uniform(0.05, 0.9)

    def fails(values: Mapping[str, str]) -> bool:
        found = int(values["a"]), float(values["load"])
        return (
            found[0] >= a and found[1] > load,
            found[0] / 100 + found[1] > a / 100 + load,
            a <= found[0] <= a + 9 and load < found[1] < load + 0.1,
        )[seed % 3]

    while True:
        values = {axis.path: axis.at(random.random()) for axis in SPACE.axes}
        if fails(values):
            return fails, values


def carry_out(strategy: Strategy, fails: Fails, space: Space = SPACE) -> list[Point]:
    """Carry out a strategy that learns; returns the points that constraints allow."""
    batches, ran = strategy.batches(space, 1), list[Point]()
    try:
        points: Sequence[Point] = next(batches)
        while True:
            assert points, "an empty batch"
            assert all(space.is_feasible(point.values) for point in points)
            ran += points
            points = batches.send([told(point, fails) for point in points])
    except StopIteration:
        return ran


def told(point: Point, fails: Fails) -> Told:
    """Return the result of a point."""
    status = End.FAILED if fails(point.values) else End.PASSED
    row = Row(1, "", 1, 1, 1, status, reason_key=FAILURE.reason_key, where=FAILURE.where)
    return Told(point, (row,))
