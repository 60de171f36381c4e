"""Contract of strategies.

A strategy yields batches of points. One that learns gets the results of a whole batch before it yields the next,
in the order of the points. So a campaign has the same runs with any number of workers, and after an interruption.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from enum import Enum
from typing import ClassVar, Protocol, TypeAlias

from seoro.campaign.runs import Point, Row
from seoro.campaign.space.space import Space
from seoro.lang.frozen import Value


class Told(Value):
    """Results of a point.

    Args:
        point: The point.
        rows: Its runs, in the order of their repeats; none if constraints exclude it.
    """

    point: Point
    rows: tuple[Row, ...]


class Sampling(Enum):
    """Relation of the points of a strategy to the whole space."""

    NONE = "none"  # points in an order, all with the same seeds, so that only their values differ
    SPREAD = "spread"  # samples spread evenly, each with a seed of its own
    INDEPENDENT = "independent"  # independent samples, each with a seed of its own: rates have intervals


Batches: TypeAlias = Generator[Sequence[Point], Sequence[Told], None]
"""Batches of points; strategies that do not learn are sent nothing."""


class Strategy(Protocol):
    """Chooses values."""

    helps: ClassVar[Mapping[str, str]]
    """Descriptions of its options, which are its fields, for the command line."""

    @property
    def name(self) -> str:
        """Name, as of `--strategy`."""

    @property
    def is_learning(self) -> bool:
        """Whether it needs the results of each batch before the next."""

    @property
    def is_endless(self) -> bool:
        """Whether it always has more points, so that a campaign needs another end."""

    @property
    def sampling(self) -> Sampling:
        """Relation of its points to the whole space."""

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches of points; refuses axes at once, not with the first batch.

        Args:
            space: Axes of the campaign, and their constraints.
            seed: Seed of all its random numbers.

        Raises:
            UsageError: It cannot be used with these axes.
        """
