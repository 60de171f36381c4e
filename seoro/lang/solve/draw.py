"""Random streams, one for each cell, so that unrelated cells do not affect each other.

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
        seed: Seed of the run.
        name: Name of the cell.
    """

    def __init__(self, seed: int, name: str) -> None:
        self._prefix = f"{seed}\0{name}\0".encode()
        self._count = 0

    def bits(self, count: int) -> int:
        """Return an integer of `count` random bits, at most 256."""
        digest = sha256(self._prefix + str(self._count).encode()).digest()
        self._count += 1
        return int.from_bytes(digest, "big") >> (256 - count)

    def below(self, limit: int) -> int:
        """Return an integer from 0 to `limit` - 1, uniformly."""
        size = (limit - 1).bit_length()
        while (found := self.bits(size)) >= limit:
            pass
        return found

    def real(self, low: float, high: float) -> float:
        """Return a real from `low` to `high`, uniformly."""
        share = self.bits(53) / 2**53
        return min(max(low * (1 - share) + high * share, low), high)

    def shuffled(self, items: tuple[Item, ...]) -> list[Item]:
        """Return items in random order (Fisher and Yates)."""
        rest, order = list(items), []
        while rest:
            order.append(rest.pop(self.below(len(rest))))
        return order


class Streams:
    """Random streams of cells, created on first use."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._streams: dict[str, Stream] = {}

    def of(self, cell: Cell) -> Stream:
        """Return the stream of a cell at its current position."""
        if cell.name not in self._streams:
            self._streams[cell.name] = Stream(self._seed, cell.name)
        return self._streams[cell.name]
