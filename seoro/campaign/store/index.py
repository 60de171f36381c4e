"""Index of the rows of a campaign, to read them in the order of their runs without having all in memory."""

from __future__ import annotations

import re
from array import array
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from itertools import islice, pairwise
from pathlib import Path
from typing import IO, Final, NamedTuple

from seoro.campaign.runs import End, Row
from seoro.campaign.store.batches import Batch
from seoro.campaign.store.folder import row_in, shards_of
from seoro.campaign.store.lines import read_lines
from seoro.files.inputs import Kind, open_input

_START: Final = re.compile(rb'\{"run": ?(\d{1,18}), ?"id": ?"\w*", ?(?:"\w+": ?-?\d+, ?)*"status": ?"(\w+)"')
_SHIFT: Final = 48  # bits of an offset in a shard
BATCH: Final = 1000  # rows
_MOST_OPEN: Final = 100  # shards


class RowIndex:
    """The rows of all runs of a campaign, in order; runs that constraints exclude are left out.

    Args:
        folder: Folder of the campaign.

    Raises:
        UsageError: A row is invalid.
    """

    def __init__(self, folder: Path) -> None:
        self._shards = shards_of(folder)
        numbers, self._places, self._passed = array("q"), array("q"), bytearray()
        self._numbers = numbers
        for number, place, end in self._found():
            if end != End.IMPOSSIBLE.value:
                numbers.append(number)
                self._places.append(place)
                self._passed.append(end == End.PASSED.value)
        self._order = array("l", range(len(numbers)))
        if not _is_increasing(numbers):
            self._sort()

    def _sort(self) -> None:
        """Order the rows by their runs; of equal runs, the first stays."""
        order, self._order = self._order, array("l")
        for position in sorted(order, key=self._numbers.__getitem__):
            if not self._order or self._numbers[position] != self._numbers[self._order[-1]]:
                self._order.append(position)

    def __len__(self) -> int:
        return len(self._order)

    def __iter__(self) -> Iterator[Row]:
        return self._read(self._order)

    def batches(self, size: int = BATCH) -> Iterator[Batch]:
        """Yield the rows in batches.

        Args:
            size: Number of rows of a batch.

        Raises:
            UsageError: A row is invalid.
        """
        lines = self._lines(self._order)
        while part := list(islice(lines, size)):
            yield Batch([line for line, _ in part], _places([place for _, place in part]))

    def find(self, run: int) -> Row | None:
        """Return the row of a run; None if it is unknown or excluded."""
        place = bisect_left(self._order, run, key=self._numbers.__getitem__)
        if place == len(self._order) or self._numbers[self._order[place]] != run:
            return None
        return next(self._read(array("l", [self._order[place]])))

    def most_important(self, most: int) -> Iterator[Row]:
        """Yield some rows in order: those of runs that did not pass come before those of others.

        Args:
            most: Maximum number.
        """
        failed = list(islice((position for position in self._order if not self._passed[position]), most))
        passed = islice((position for position in self._order if self._passed[position]), most - len(failed))
        chosen = {*failed, *passed}
        return self._read(position for position in self._order if position in chosen)

    def _found(self) -> Iterator[tuple[int, int, str]]:
        """Yield number, place and end of each row."""
        for shard, path in enumerate(self._shards):
            offset = 0
            for number, line in enumerate(read_lines(path), start=1):
                run, end = end_in(line, f"{path}:{number}")
                yield run, shard << _SHIFT | offset, end
                offset += len(line)

    def _read(self, positions: Iterable[int]) -> Iterator[Row]:
        for line, place in self._lines(positions):
            yield row_in(line, str(place))

    def _lines(self, positions: Iterable[int]) -> Iterator[tuple[bytes, _Place]]:
        """Yield lines with their places."""
        opened: dict[int, IO[bytes]] = {}
        ends: dict[int, int] = {}  # offset behind the last line that was read, by shard
        with ExitStack() as stack:
            for position in positions:
                shard, offset = divmod(self._places[position], 1 << _SHIFT)
                file = opened.get(shard)
                if file is None:
                    if len(opened) == _MOST_OPEN:
                        stack.close()
                        opened.clear()
                        ends.clear()
                    file = opened[shard] = stack.enter_context(open_input(self._shards[shard], Kind.CAMPAIGN))
                if ends.get(shard) != offset:
                    file.seek(offset)  # it discards the buffer
                line = file.readline()
                ends[shard] = offset + len(line)
                yield line, _Place(self._shards[shard], offset)


def end_in(line: bytes, place: str) -> tuple[int, str]:
    """Return the number and the end of the run of a line; decoding all lines would take most of the time.

    Args:
        line: Line of a shard.
        place: Its place, for messages.

    Raises:
        UsageError: The line is invalid.
    """
    start = _START.match(line)
    if start is not None:
        return int(start[1]), start[2].decode()
    row = row_in(line, place)
    return row.run, row.status.value


class _Place(NamedTuple):
    """Place of a line, for messages."""

    shard: Path
    offset: int

    def __str__(self) -> str:
        return f"{self.shard}, byte {self.offset}"


def _places(places: Sequence[_Place]) -> Callable[[int], str]:
    return lambda position: str(places[position])


def _is_increasing(numbers: array[int]) -> bool:
    return all(before < after for before, after in pairwise(numbers))
