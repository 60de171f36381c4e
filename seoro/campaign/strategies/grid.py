"""Grid: all combinations of the values of axes, the last of which varies fastest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, product
from typing import TypeVar

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis, Choices
from seoro.campaign.strategies.contract import Batches
from seoro.errors import UsageError
from seoro.lang.frozen import Value

BATCH = 256  # points made at a time

T = TypeVar("T")


class Grid(Value):
    """All combinations.

    Args:
        levels: Number of values of each axis with bounds, both included; 0 to let each run draw its value.
    """

    levels: int = 0
    name = "grid"
    is_learning = False

    def batches(self, axes: Sequence[Axis], seed: int) -> Batches:
        """Return the combinations; see `Strategy`."""
        listed = [axis for axis in axes if isinstance(axis, Choices) or self.levels]
        if axes and not listed:
            axis = axes[0]
            raise UsageError(
                f"`{axis.path}` varies within a range, of which a grid has no values",
                axis.span,
                help="add `--levels 5` for five values of each range, or choose `--strategy random --runs 200`",
            )
        return self._combinations(listed)

    def _combinations(self, axes: Sequence[Axis]) -> Batches:
        paths = [axis.path for axis in axes]
        for batch in batches_of(product(*map(self._texts, axes))):
            yield [Point(dict(zip(paths, texts, strict=True))) for texts in batch]

    def _texts(self, axis: Axis) -> Sequence[str]:
        return axis.texts if isinstance(axis, Choices) else axis.levels(self.levels)


def batches_of(items: Iterable[T]) -> Iterator[Sequence[T]]:
    """Group items into batches, without making them earlier than needed."""
    rest = iter(items)
    while batch := list(islice(rest, BATCH)):
        yield batch
