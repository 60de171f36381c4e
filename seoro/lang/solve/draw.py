"""Random streams, one for each cell: what is drawn for one does not depend on cells that it has no part in.

A stream is the sequence of SHA-256 digests of seed, name and a counter: the same on every machine and in every
version of Python, unlike the methods of `random.Random`.
"""

from __future__ import annotations

from hashlib import sha256
from typing import TypeVar

from seoro.lang.solve.cells import Cell

Item = TypeVar("Item")


class Stream:
    """An endless sequence of random numbers.

    Args:
        seed: The run's.
        name: What is drawn.
    """

    def __init__(self, seed: int, name: str) -> None:
        self._prefix = f"{seed}\0{name}\0".encode()
        self._count = 0

    def bits(self, count: int) -> int:
        """A whole number of `count` random bits, at most 256."""
        digest = sha256(self._prefix + str(self._count).encode()).digest()
        self._count += 1
        return int.from_bytes(digest, "big") >> (256 - count)

    def below(self, limit: int) -> int:
        """A whole number from 0 to `limit` - 1, each as likely as the others."""
        size = (limit - 1).bit_length()
        while (found := self.bits(size)) >= limit:
            pass
        return found

    def real(self, low: float, high: float) -> float:
        """A real from `low` to `high`, uniformly."""
        share = self.bits(53) / 2**53
        return min(max(low * (1 - share) + high * share, low), high)

    def shuffled(self, items: tuple[Item, ...]) -> list[Item]:
        """Items in random order (Fisher and Yates)."""
        rest, order = list(items), []
        while rest:
            order.append(rest.pop(self.below(len(rest))))
        return order


class Streams:
    """The streams of cells, each made when it is first drawn from."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._streams: dict[str, Stream] = {}

    def of(self, cell: Cell) -> Stream:
        """The stream of a cell, which goes on where it was."""
        if cell.name not in self._streams:
            self._streams[cell.name] = Stream(self._seed, cell.name)
        return self._streams[cell.name]
