"""Rows of a campaign in batches, by column: reading a large campaign takes half of the time of single rows.

Lines that seoro wrote are decoded together, without their coverage, which often repeats. Other valid lines are
decoded one by one.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Final

from pydantic_core import from_json

from seoro.campaign.numbers import Numbers
from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import row_in, shards_of
from seoro.campaign.store.lines import read_blocks
from seoro.runtime.trace.jsonl import to_json

_NAMES: Final[tuple[str, ...]] = Row.__match_args__[:-1]
_COVERAGE: Final = b', "coverage": ['  # the last field; within it, no key has a list
_END: Final = b"}\n"  # of a line
_STATUS: Final = _NAMES.index("status")
_ENDS: Final = {end.value: end for end in End}


class Batch:
    """Rows of several runs.

    Args:
        lines: Their lines.
        place: Returns the place of a line, for messages, from its position.

    Raises:
        UsageError: A line is invalid.
    """

    def __init__(self, lines: Sequence[bytes], place: Callable[[int], str]) -> None:
        self._lines = lines
        self._place = place
        divided = [line.rpartition(_COVERAGE) for line in lines]
        self._coverage = [rest for _, _, rest in divided]
        columns = _together(head for head, _, _ in divided)
        if columns is None:
            rows = [self.row(position) for position in range(len(lines))]
            columns = [[getattr(row, name) for row in rows] for name in _NAMES]
            columns[_STATUS] = [row.status.value for row in rows]
            self._coverage = [_coverage_of(row) for row in rows]
        self._columns = dict(zip(_NAMES, columns, strict=True))

    def __len__(self) -> int:
        return len(self._lines)

    def column(self, name: str) -> Sequence[Any]:
        """Return a field of all rows, other than their coverage.

        Args:
            name: Name of the field.
        """
        return self._columns[name]

    @cached_property
    def ends(self) -> Mapping[End, Sequence[int]]:
        """Positions of the rows with each end, from 0; ends without a row are left out."""
        found: defaultdict[str, list[int]] = defaultdict(list)
        for position, end in enumerate(self._columns["status"]):
            found[end].append(position)
        return {end: found[end.value] for end in End if end.value in found}

    def coverage(self, positions: Iterable[int]) -> Iterator[tuple[Sequence[Mapping[str, Any]], Sequence[int]]]:
        """Yield each different coverage, with the positions of its rows.

        Args:
            positions: Positions of the rows to look at.

        Raises:
            UsageError: A row is invalid.
        """
        found: defaultdict[bytes, list[int]] = defaultdict(list)
        for position in positions:
            found[self._coverage[position]].append(position)
        for text, same in found.items():
            try:
                items = from_json(b"[%b" % text[: -len(_END)])
            except ValueError:
                items = self.row(same[0]).coverage
            yield items, same

    def row(self, position: int) -> Row:
        """Return a row.

        Args:
            position: Its position.

        Raises:
            UsageError: It is invalid.
        """
        return row_in(self._lines[position], self._place(position))

    def select(self, positions: Sequence[int]) -> Batch:
        """Return some of the rows.

        Args:
            positions: Their positions.
        """
        return Batch([self._lines[each] for each in positions], lambda each: self._place(positions[each]))


def read_batches(folder: Path) -> Iterator[Batch]:
    """Yield the rows of all runs that have ended, once each, in no order.

    Args:
        folder: Folder of the campaign.

    Raises:
        UsageError: A row is invalid.
    """
    seen = Numbers()
    for path in shards_of(folder):
        first = 1
        for lines in read_blocks(path):
            batch = Batch(lines, partial(_place, path, first))
            first += len(lines)
            new = [position for position, run in enumerate(batch.column("run")) if seen.add(run)]
            yield batch if len(new) == len(batch) else batch.select(new)


def _together(heads: Iterable[bytes]) -> list[Sequence[Any]] | None:
    """Decode rows without their coverage to columns; None if one is invalid, or has not the usual fields."""
    try:
        rows = from_json(b"[%b}]" % b"},".join(heads))
        columns: list[Sequence[Any]] = [*zip(*map(dict.values, rows), strict=True)]
        is_usual = set(map(tuple, rows)) == {_NAMES} and set(columns[_STATUS]) <= _ENDS.keys()
    except (ValueError, TypeError, IndexError):  # also for halves of surrogate pairs
        return None
    return columns if is_usual else None


def _coverage_of(row: Row) -> bytes:
    """Return the coverage of a row as it would be in a line of seoro."""
    return to_json(row.coverage).encode("utf-8", "backslashreplace")[1:] + _END


def _place(path: Path, first: int, position: int) -> str:
    return f"{path}:{first + position}"
