"""Random sample of rows whose number is unknown."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Generic, TypeVar

_Item = TypeVar("_Item")


class Reservoir(Generic[_Item]):
    """Uniform random sample; most items cost nothing (algorithm L in Li, ACM TOMS 20, 1994).

    Args:
        most: Maximum number of items in the sample.
        seed: Random seed.

    Attributes:
        items: The sample.
        count: Number of all items.
    """

    def __init__(self, most: int, seed: int) -> None:
        self.items: list[_Item] = []
        self.count = 0
        self._most = most
        self._draw = random.Random(seed)  # noqa: S311 - no secret
        self._weight = 1.0
        self._next = most - 1  # number of the next item that enters the full sample
        self._skip()

    def extend(self, items: Sequence[_Item]) -> None:
        """Take items."""
        self.items.extend(items[: self._most - len(self.items)])
        end = self.count + len(items)
        while self._next < end:
            self.items[self._draw.randrange(self._most)] = items[self._next - self.count]
            self._skip()
        self.count = end

    def _skip(self) -> None:
        self._weight *= math.exp(math.log(1.0 - self._draw.random()) / self._most)
        self._next += math.floor(math.log(1.0 - self._draw.random()) / math.log1p(-self._weight)) + 1
