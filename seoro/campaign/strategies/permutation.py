"""Random permutations without a list, so that the first of a million points is there at once."""

from __future__ import annotations

from random import Random
from typing import Final

ROUNDS: Final = 4  # of a Feistel network, enough to look random (Luby, Rackoff, 1988)
_MIX: Final = 0x9E3779B97F4A7C15  # odd, with bits in no order: 2^64 divided by the golden ratio
_WORD: Final = (1 << 64) - 1


class Permutation:
    """Permutation of the whole numbers below `size`.

    A Feistel network permutes the numbers below the next power of four. Numbers that leave the range are permuted
    again until they return (Black, Rogaway, "Ciphers with arbitrary finite domains", 2002).

    Args:
        size: Number of numbers, from 1.
        random: Source of its keys.
    """

    def __init__(self, size: int, random: Random) -> None:
        self._size = size
        self._bits = max(1, ((size - 1).bit_length() + 1) // 2)  # of each half
        self._keys = [random.getrandbits(64) for _ in range(ROUNDS)]

    def __call__(self, number: int) -> int:
        """Return the number at a place."""
        while (number := self._permuted(number)) >= self._size:
            pass
        return number

    def _permuted(self, number: int) -> int:
        mask = (1 << self._bits) - 1
        left, right = number >> self._bits, number & mask
        for key in self._keys:
            mixed = (right + 1 ^ key) * _MIX & _WORD
            mixed = (mixed ^ mixed >> 29) * _MIX & _WORD
            left, right = right, left ^ (mixed >> 32 & mask)
        return left << self._bits | right
