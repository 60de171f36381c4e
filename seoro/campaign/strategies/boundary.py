"""Boundary values: ends of ranges and one step beside, with the other parameters at usual values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from typing import ClassVar, Final

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.campaign.strategies.grid import batches_of
from seoro.lang.frozen import Value

STEP: Final = 0.01  # of a range, from its end; of whole numbers, at least 1


class Boundary(Value):
    """The usual values, then each axis at each of its boundaries.

    The other axes have their default values, or those in the middle. If constraints exclude these, the run draws
    them.

    Args:
        pairs: Whether any two axes are at boundaries, too.
    """

    pairs: bool = False
    name = "boundary"
    is_learning = False
    is_endless = False
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {"pairs": "also run any two parameters at their boundaries"}

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the points; see `Strategy`."""
        yield from batches_of(self._points(space))

    def _points(self, space: Space) -> Iterator[Point]:
        usual = {axis.path: space.usual.get(axis.path) or middle(axis) for axis in space.axes}
        seen: set[tuple[tuple[str, str], ...]] = set()
        for number in range(3 if self.pairs else 2):
            for axes in combinations(space.axes, number):
                for texts in product(*map(boundaries, axes)):
                    chosen = dict(zip((axis.path for axis in axes), texts, strict=True))
                    values = {**usual, **chosen}
                    if not space.is_feasible(values):
                        values = chosen
                    key = tuple(sorted(values.items()))
                    if key not in seen:
                        seen.add(key)
                        yield Point(values, " ".join(f"{path}={text}" for path, text in chosen.items()))


def boundaries(axis: Axis) -> Sequence[str]:
    """Return the boundary values of an axis.

    Args:
        axis: The axis.

    Returns:
        Of a range, its ends and one step inside of each; of listed numbers, the two least and the two largest; of
        values without order, all.
    """
    if isinstance(axis, Choices):
        if axis.numbers is None:
            return axis.texts
        order = _in_order(axis)
        return order if len(order) <= 4 else order[:2] + order[-2:]
    width = axis.high - axis.low
    step = max(1, round(width * STEP)) if axis.is_whole else width * STEP
    values = (axis.low, axis.low + step, axis.high - step, axis.high)
    inside = sorted({value for value in values if axis.low <= value <= axis.high})
    return tuple(dict.fromkeys(map(axis.text, inside)))


def middle(axis: Axis) -> str:
    """Return the value in the middle; of values without order, the first."""
    if isinstance(axis, Choices):
        return axis.texts[0] if axis.numbers is None else _in_order(axis)[(len(axis.texts) - 1) // 2]
    value = (axis.low + axis.high) / 2
    return axis.text(value // 1 if axis.is_whole else value)


def _in_order(axis: Choices) -> tuple[str, ...]:
    assert axis.numbers is not None
    return tuple(text for _, text in sorted(zip(axis.numbers, axis.texts, strict=True)))
