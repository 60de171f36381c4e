"""The worst run of each kind, for reports about campaigns with MAP-Elites."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from seoro.campaign.runs import Point, Row
from seoro.campaign.strategies.contract import Told
from seoro.campaign.strategies.map_elites import BATCH, MapElites, cells_of
from seoro.campaign.strategies.objective import number_in
from seoro.errors import UsageError


class Elite(NamedTuple):
    """The worst run of a kind.

    Args:
        kind: The kind, a text for each dimension: a bucket, or ranges of two columns.
        row: The run.
        value: Value of the column that the search lowers or raises; None without one.
    """

    kind: tuple[str, ...]
    row: Row
    value: float | None


class Elites(NamedTuple):
    """The worst runs of all kinds, the worst first.

    Args:
        titles: Names of the dimensions of a kind: a `cover` item, or two columns.
        column: Column that the search lowers or raises.
        elites: The runs.
    """

    titles: tuple[str, ...]
    column: str
    elites: Sequence[Elite]


def elites_of(strategy: MapElites, items: Sequence[str], rows: Callable[[], Iterable[Row]]) -> Elites | None:
    """Return the worst run of each kind, as the strategy sees it; None if no run has what determines its kind.

    Args:
        strategy: The strategy.
        items: Names of the `cover` items of the scenario.
        rows: Returns the rows of a campaign, in order; they are read twice.
    """
    try:
        cells = cells_of(strategy.cells, items)
        cells.learn([row for row in rows() if row.variant <= BATCH])
    except UsageError:
        return None
    objective = strategy.objective
    worst: dict[tuple[str, ...], tuple[float, Row]] = {}
    for row in rows():
        told = Told(Point(row.values), (row,))
        value = objective.value(told)
        for kind in cells.kinds(told) if value is not None else ():
            if value is not None and (kind not in worst or value < worst[kind][0]):
                worst[kind] = value, row
    found = sorted(worst.items(), key=lambda each: (each[1][0], each[1][1].run))
    return Elites(
        cells.titles,
        objective.column,
        [Elite(kind, row, number_in(row, objective.column)) for kind, (_, row) in found],
    )
