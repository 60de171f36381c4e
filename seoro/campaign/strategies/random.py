"""Random sampling: each axis is drawn on its own, uniformly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from random import Random
from typing import ClassVar

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.campaign.strategies.grid import batches_of
from seoro.lang.frozen import Value


class Uniform(Value):
    """Independent draws without an end."""

    name = "random"
    is_learning = False
    is_endless = True
    sampling = Sampling.INDEPENDENT
    helps: ClassVar[Mapping[str, str]] = {}

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the draws; see `Strategy`."""
        yield from batches_of(_draws(space.axes, Random(seed)))  # noqa: S311 - not for secrets


def _draws(axes: Sequence[Axis], random: Random) -> Iterator[Point]:
    while True:
        yield Point({axis.path: axis.at(random.random()) for axis in axes})
