"""Latin hypercube: of N points, each axis has one in each of N equal parts.

McKay, Beckman, Conover, "A comparison of three methods for selecting values of input variables", 1979.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from random import Random
from typing import ClassVar

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.campaign.strategies.grid import batches_of
from seoro.campaign.strategies.permutation import Permutation
from seoro.errors import UsageError
from seoro.lang.frozen import Value


class Latin(Value):
    """Latin hypercubes, one after another: more than `size` points begin the next.

    Args:
        size: Number of points of a hypercube.
    """

    size: int = 0
    name = "latin"
    is_learning = False
    is_endless = True
    sampling = Sampling.SPREAD
    helps: ClassVar[Mapping[str, str]] = {"size": "number of points of a hypercube (default: of --runs)"}

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the points; see `Strategy`."""
        if self.size < 1:
            raise UsageError("a Latin hypercube needs its number of points", help="add `--runs 200`")
        return self._batches(space.axes, seed)

    def _batches(self, axes: Sequence[Axis], seed: int) -> Batches:
        yield from batches_of(self._points(axes, Random(seed)))  # noqa: S311 - not for secrets

    def _points(self, axes: Sequence[Axis], random: Random) -> Iterator[Point]:
        while True:
            parts = [Permutation(self.size, random) for _ in axes]
            for number in range(self.size):
                yield Point(
                    {
                        axis.path: axis.at((part(number) + random.random()) / self.size)
                        for axis, part in zip(axes, parts, strict=True)
                    }
                )
