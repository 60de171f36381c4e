"""Spaces for tests of strategies."""

from __future__ import annotations

from itertools import islice

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Choices, Interval
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Strategy
from seoro.lang.plan import PrimitiveType
from seoro.lang.source import SourceFile, Span

SPAN = Span(SourceFile("main.osc", ""), 0, 0)


def listed(path: str, number: int) -> Choices:
    """An axis with the values 0, 1, 2, ..."""
    return Choices(path, tuple(map(str, range(number))), tuple(map(float, range(number))), SPAN)


def ranged(path: str, low: float = 0.0, high: float = 1.0, *, is_whole: bool = False) -> Interval:
    """An axis with bounds."""
    return Interval(path, low, high, is_whole, PrimitiveType("int" if is_whole else "float"), SPAN)


def points(strategy: Strategy, space: Space, seed: int = 1, most: int = 100_000) -> list[Point]:
    """The points of a strategy that does not learn."""
    batches = strategy.batches(space, seed)
    return list(islice((point for batch in batches for point in batch), most))
