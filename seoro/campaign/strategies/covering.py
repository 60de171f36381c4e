"""Covering arrays: each combination of values of any two (or more) parameters occurs in a run.

A row is built greedily: it begins with an uncovered combination, and each further parameter gets the value that
covers most of the others. Of several such rows, the best is taken (Cohen, Dalal, Fredman, Patton, "The AETG
system", 1997).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations, product
from random import Random
from typing import Final, TypeAlias

CANDIDATES: Final = 30  # rows to choose from; more make arrays hardly smaller
MOST: Final = 500_000  # combinations of an array

Row: TypeAlias = tuple[int | None, ...]
"""Index of the value of each parameter; None if the run draws the value."""
Allowed: TypeAlias = Callable[[Mapping[int, int]], bool]
"""Returns whether constraints allow values, by parameter, with some values of the others."""


def combinations_of(sizes: Sequence[int], strength: int) -> int:
    """Return the number of combinations that an array covers."""
    return sum(math.prod(each) for each in combinations(sizes, strength))


def covering_rows(sizes: Sequence[int], strength: int, seed: int, is_allowed: Allowed) -> Iterator[Row]:
    """Yield the rows of a covering array.

    Args:
        sizes: Number of values of each parameter.
        strength: Number of parameters of a combination, at least 2.
        seed: Seed of random choices between values that are equally good.
        is_allowed: Constraints; combinations that they exclude are left out.
    """
    if strength >= len(sizes):
        yield from (row for row in product(*map(range, sizes)) if is_allowed(dict(enumerate(row))))
        return
    array = _Array(sizes, strength, Random(seed))  # noqa: S311 - not for secrets
    while (wanted := array.next_uncovered()) is not None:
        row = array.best_row(wanted)
        if not is_allowed(row):
            if not is_allowed(wanted):
                array.cover(wanted)  # excluded
                continue
            row = array.row(wanted, is_allowed)
        array.cover(row)
        yield tuple(row.get(axis) for axis in range(len(sizes)))


class _Array:
    """Combinations without a row. Values have numbers; sets of these are bits of whole numbers."""

    def __init__(self, sizes: Sequence[int], strength: int, random: Random) -> None:
        self._strength = strength
        self._random = random
        self._first = [sum(sizes[:axis]) for axis in range(len(sizes))]  # numbers of the first values
        self._sizes = sizes
        self._uncovered: dict[tuple[int, ...], int] = {}  # last values of combinations, by all others
        self._left: list[tuple[int, ...]] = []
        for axes in combinations(range(len(sizes)), strength):
            self._left += product(*(range(self._first[axis], self._first[axis] + sizes[axis]) for axis in axes))
        for values in self._left:
            for value in values:
                others = tuple(each for each in values if each != value)
                self._uncovered[others] = self._uncovered.get(others, 0) | 1 << value
        random.shuffle(self._left)
        self._axis = [axis for axis, size in enumerate(sizes) for _ in range(size)]  # of each value

    def next_uncovered(self) -> dict[int, int] | None:
        """Return an uncovered combination; None after the last."""
        while self._left:
            *others, last = self._left[-1]
            if self._uncovered[tuple(others)] >> last & 1:
                return {self._axis[value]: value - self._first[self._axis[value]] for value in self._left[-1]}
            self._left.pop()
        return None

    def best_row(self, wanted: Mapping[int, int]) -> dict[int, int]:
        """Return a row with a combination that covers many others, too."""
        return max((self.row(wanted) for _ in range(CANDIDATES)), key=self._covered)

    def row(self, wanted: Mapping[int, int], is_allowed: Allowed | None = None) -> dict[int, int]:
        """Return a row with a combination.

        Args:
            wanted: The combination.
            is_allowed: Constraints; parameters without an allowed value are left out.
        """
        row = dict(wanted)
        rest = [axis for axis in range(len(self._sizes)) if axis not in row]
        self._random.shuffle(rest)
        for axis in rest:
            for value in self._preferred(axis, row):
                if is_allowed is None or is_allowed({**row, axis: value}):
                    row[axis] = value
                    break
        return row

    def _preferred(self, axis: int, row: Mapping[int, int]) -> list[int]:
        """Return the values of a parameter, the one that covers most first; equal ones in random order."""
        values = list(range(self._sizes[axis]))
        self._random.shuffle(values)
        numbers = self._numbers(row)
        bits = sum(1 << number for number in numbers)
        parts = list(combinations(numbers, self._strength - 2))
        first = self._first[axis]
        return sorted(values, key=lambda value: self._gain(first + value, parts, bits), reverse=True)

    def _gain(self, value: int, parts: Sequence[tuple[int, ...]], bits: int) -> int:
        """Return how many combinations a value covers with others, each counted `strength - 1` times."""
        uncovered = self._uncovered
        return sum((uncovered[tuple(sorted((*part, value)))] & bits).bit_count() for part in parts)

    def _covered(self, row: Mapping[int, int]) -> int:
        """Return how many combinations a row covers, each counted `strength` times."""
        numbers = self._numbers(row)
        bits = sum(1 << number for number in numbers)
        parts = combinations(numbers, self._strength - 1)
        return sum((self._uncovered[part] & bits).bit_count() for part in parts)

    def cover(self, row: Mapping[int, int]) -> None:
        """Mark the combinations of a row as covered."""
        numbers = self._numbers(row)
        bits = sum(1 << number for number in numbers)
        for part in combinations(numbers, self._strength - 1):
            self._uncovered[part] &= ~bits

    def _numbers(self, row: Mapping[int, int]) -> list[int]:
        return sorted(self._first[axis] + value for axis, value in row.items())
