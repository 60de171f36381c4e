"""Grid: all combinations of the values of axes, the last of which varies fastest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import ClassVar, TypeVar

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling
from seoro.errors import UsageError
from seoro.lang.frozen import Value

BATCH = 256  # points made at a time
LEVELS = "number of values of each range"

T = TypeVar("T")


class Grid(Value):
    """All combinations.

    Args:
        levels: Number of values of each axis with bounds, both included; 0 to let each run draw its value.
    """

    levels: int = 0
    name = "grid"
    is_learning = False
    is_endless = False
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {"levels": LEVELS}

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the combinations; see `Strategy`."""
        return self._combinations(listed_axes(space, self.levels, self.name))

    def _combinations(self, axes: Sequence[Axis]) -> Batches:
        paths = [axis.path for axis in axes]
        for batch in batches_of(_combinations([values_of(axis, self.levels) for axis in axes])):
            yield [Point(dict(zip(paths, texts, strict=True))) for texts in batch]


def _combinations(values: Sequence[Sequence[str]]) -> Iterator[tuple[str, ...]]:
    """Yield one value of each list; unlike `itertools.product`, without making all values first."""
    if not values:
        yield ()
        return
    for first in values[0]:
        for rest in _combinations(values[1:]):
            yield (first, *rest)


def listed_axes(space: Space, levels: int, name: str) -> Sequence[Axis]:
    """Return the axes that have a number of values.

    Args:
        space: The space.
        levels: Number of values of each range; 0 for none.
        name: Name of the strategy, for the message.

    Raises:
        UsageError: All axes are ranges without values.
    """
    listed = [axis for axis in space.axes if isinstance(axis, Choices) or levels]
    if space.axes and not listed:
        axis = space.axes[0]
        raise UsageError(
            f"`{axis.path}` varies within a range, of which the strategy `{name}` has no values",
            axis.span,
            help="add `--levels 5` for five values of each range, or choose `--strategy random --runs 200`",
        )
    return listed


def values_of(axis: Axis, levels: int) -> Sequence[str]:
    """Return the values of an axis; of a range, equidistant ones."""
    return axis.texts if isinstance(axis, Choices) else axis.levels(levels)


def batches_of(items: Iterable[T]) -> Iterator[Sequence[T]]:
    """Group items into batches, without making them earlier than needed."""
    rest = iter(items)
    while batch := list(islice(rest, BATCH)):
        yield batch
