"""Search for the worst runs of many kinds: MAP-Elites, by pyribs.

Each kind of run is a cell: a bucket of a `cover` item, or a pair of bins of two columns. New points mix and vary
the worst runs of cells.

Mouret, Clune, "Illuminating search spaces by mapping elites", 2015. Vassiliades, Mouret, "Discovering the elite
hypervolume by leveraging interspecies correlation", 2018.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from random import Random
from typing import TYPE_CHECKING, ClassVar, Final, Protocol

from seoro.campaign.runs import End, Row
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling, Told
from seoro.campaign.strategies.objective import MAXIMIZE, MINIMIZE, Objective, number_in, objective_of
from seoro.campaign.strategies.optimizers import check_installed
from seoro.campaign.strategies.shares import TRIES, Shares, hypercube, point_at
from seoro.errors import UsageError
from seoro.lang.diagnostics import near
from seoro.lang.frozen import Value

if TYPE_CHECKING:
    from ribs.emitters import IsoLineEmitter

BATCH: Final = 20  # points between two lessons
BINS: Final = 10  # of each of two columns
BUCKETS: Final = 1000  # of an item, each a cell
FAILED: Final = 1e9  # objective of failed runs, and bound of others; an archive has finite ones only
SEEDS: Final = 1 << 32  # of numpy
_LARGEST: Final = 1.0 - 2.0**-53  # share


class MapElites(Value):
    """Search for the worst run of each cell.

    Args:
        minimize: Column that is small near failures; empty for `margin`.
        maximize: Column that is large near failures, instead.
        cells: A `cover` item, whose buckets are cells, or two columns `A,B`; empty for the first `cover` item.
    """

    minimize: str = ""
    maximize: str = ""
    cells: str = ""
    name = "map-elites"
    is_learning = True
    is_endless = True
    sampling = Sampling.NONE
    helps: ClassVar[Mapping[str, str]] = {
        "minimize": MINIMIZE,
        "maximize": MAXIMIZE,
        "cells": "cover item whose buckets are kinds of runs, or two columns A,B (default: the first cover item)",
    }

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches; see `Strategy`."""
        if not space.axes:
            raise UsageError("a search needs a parameter that varies")
        check_installed(self.name, "ribs")
        return self._batches(
            space, self.objective, cells_of(self.cells, [each.item for each in space.items]), seed
        )

    @property
    def objective(self) -> Objective:
        """Value that the search lowers.

        Raises:
            UsageError: Two columns are given.
        """
        return objective_of(self.minimize, self.maximize)

    def _batches(self, space: Space, objective: Objective, cells: Cells, seed: int) -> Batches:
        from ribs.archives import GridArchive  # noqa: PLC0415 - an extra
        from ribs.emitters import IsoLineEmitter  # noqa: PLC0415 - the same

        drawn = list(hypercube(BATCH, len(space.axes), Random(seed)))  # noqa: S311 - not for secrets
        told = yield [point_at(space.axes, shares) for shares in drawn]
        objective.is_known(told)
        dimensions, ranges = cells.learn([row for each in told for row in each.rows])
        size = len(space.axes)
        archive = GridArchive(solution_dim=size, dims=dimensions, ranges=ranges, seed=seed % SEEDS)
        emitter = IsoLineEmitter(
            archive, x0=[0.5] * size, bounds=[(0.0, 1.0)] * size, batch_size=BATCH, seed=(seed + 1) % SEEDS
        )
        while True:
            for shares, each in zip(drawn, told, strict=True):
                value = objective.value(each)
                if value is not None:
                    for place in cells.places(each):
                        archive.add_single(list(shares), min(max(-value, -FAILED), FAILED), place)
            drawn = _allowed(emitter, space)
            told = yield [point_at(space.axes, shares) for shares in drawn]


def _allowed(emitter: IsoLineEmitter, space: Space) -> list[Shares]:
    """Return the next points that constraints allow; after some tries, also others."""
    found: list[Shares] = []
    for left in reversed(range(TRIES)):
        for row in emitter.ask().tolist():
            shares = tuple(min(share, _LARGEST) for share in row)
            if len(found) < BATCH and (not left or space.is_feasible(point_at(space.axes, shares).values)):
                found.append(shares)
        if len(found) == BATCH:
            break
    return found


def cells_of(text: str, known: Sequence[str]) -> Cells:
    """Return the cells of a search.

    Args:
        text: Value of the option `--cells`.
        known: Names of the `cover` items of the scenario.

    Raises:
        UsageError: The item is unknown, or the option is invalid.
    """
    if "," not in text:
        return _Buckets(_item(text, known))
    columns = [each.strip() for each in text.split(",")]
    if len(columns) != 2 or not all(columns):
        raise UsageError(
            f"invalid `--cells {text}`: expected a `cover` item, or two columns",
            help="for example `--cells robot.path_length,robot.max_speed`",
        )
    return _Columns(columns[0], columns[1])


def _item(name: str, known: Sequence[str]) -> str:
    """Return the name of the `cover` item whose buckets are cells.

    Raises:
        UsageError: The scenario does not have it.
    """
    if not known:
        raise UsageError(
            "the scenario has no `cover` item, whose buckets would be the cells of the search",
            help="add `cover` to the scenario, or choose two columns: `--cells robot.path_length,duration`",
        )
    if name and name not in known:
        raise UsageError(f"unknown `cover` item `{name}`", help=near(name, known) or f"items: {', '.join(known)}")
    return name or known[0]


class Cells(Protocol):
    """Kinds of runs, as places in a grid."""

    @property
    def titles(self) -> tuple[str, ...]:
        """Names of the dimensions of a kind: a `cover` item, or two columns."""

    def learn(self, rows: Sequence[Row]) -> tuple[list[int], list[tuple[float, float]]]:
        """Return the number of bins and the range of each dimension.

        Args:
            rows: First runs.

        Raises:
            UsageError: They do not have what determines the cells.
        """

    def places(self, told: Told) -> Iterator[Sequence[float]]:
        """Yield the places of a point."""

    def kinds(self, told: Told) -> Iterator[tuple[str, ...]]:
        """Yield the places of a point as texts, one for each title."""


class _Buckets:
    """Buckets of a `cover` item, numbered in the order in which runs reach them."""

    def __init__(self, item: str) -> None:
        self._item = item
        self.titles = (item,)
        self._numbers: dict[str, int] = {}

    def learn(self, rows: Sequence[Row]) -> tuple[list[int], list[tuple[float, float]]]:
        """See `Cells`."""
        return [BUCKETS], [(0.0, float(BUCKETS))]

    def places(self, told: Told) -> Iterator[Sequence[float]]:
        """See `Cells`."""
        for (bucket,) in self.kinds(told):
            number = self._numbers.setdefault(bucket, len(self._numbers))
            yield [min(number, BUCKETS - 1) + 0.5]

    def kinds(self, told: Told) -> Iterator[tuple[str, ...]]:
        """See `Cells`."""
        reached = {
            bucket: None
            for row in told.rows
            for each in row.coverage
            if each["item"] == self._item and each["kind"] == "cover"
            for bucket in each["buckets"]
        }
        yield from ((bucket,) for bucket in reached)


class _Columns:
    """Bins of two columns; their ranges are those of the first runs, and half of that beyond both ends."""

    def __init__(self, first: str, second: str) -> None:
        self.titles = (first, second)
        self._ranges: list[tuple[float, float]] = []

    def learn(self, rows: Sequence[Row]) -> tuple[list[int], list[tuple[float, float]]]:
        """See `Cells`."""
        self._ranges = [self._range(column, rows) for column in self.titles]
        return [BINS, BINS], self._ranges

    def _range(self, column: str, rows: Sequence[Row]) -> tuple[float, float]:
        found = [number for row in rows if (number := number_in(row, column)) is not None]
        if not found:
            raise UsageError(
                f"no run has a number in the column `{column}`", help="choose other columns: `--cells A,B`"
            )
        low, high = min(found), max(found)
        beyond = (high - low) / 2.0 or 0.5
        return low - beyond, high + beyond

    def places(self, told: Told) -> Iterator[Sequence[float]]:
        """See `Cells`."""
        for row in told.rows:
            place = [number_in(row, column) for column in self.titles]
            if row.status in (End.PASSED, End.FAILED) and None not in place:
                yield [number for number in place if number is not None]

    def kinds(self, told: Told) -> Iterator[tuple[str, ...]]:
        """See `Cells`."""
        for place in self.places(told):
            yield tuple(map(_bin, place, self._ranges))


def _bin(number: float, bounds: tuple[float, float]) -> str:
    """Return the bounds of the bin of a number; the outer bins hold numbers beyond them, too."""
    low, width = bounds[0], (bounds[1] - bounds[0]) / BINS
    place = min(max(int((number - low) / width), 0), BINS - 1)
    return f"{low + place * width:.4g}..{low + (place + 1) * width:.4g}"
