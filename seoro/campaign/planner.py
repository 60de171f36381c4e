"""Planner of a campaign: the next runs, lazily, also after an interruption."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence

from seoro.campaign.numbers import Numbers
from seoro.campaign.runs import End, Planned, Point, Row
from seoro.campaign.space.space import Space
from seoro.campaign.store.batches import Batch, read_batches
from seoro.campaign.store.folder import CampaignFolder
from seoro.campaign.strategies.contract import Batches, Sampling, Strategy, Told
from seoro.errors import UsageError

MOST_IMPOSSIBLE = 1000  # runs without a possible one among them, before planning is given up


class Planner:
    """Plans the runs of a campaign.

    Args:
        folder: Folder of the campaign. Planned runs of an earlier session that have not ended come first.
        strategy: Chooses the values.
        space: Axes of the campaign, and their constraints.
        on_batch: Called with the rows of an earlier session, so that these are read once.

    Raises:
        UsageError: The strategy cannot be used with these axes, or a file of the folder is invalid.
    """

    def __init__(
        self,
        folder: CampaignFolder,
        strategy: Strategy,
        space: Space,
        on_batch: Callable[[Batch], object] = lambda batch: None,
    ) -> None:
        self._folder = folder
        self._campaign = folder.campaign
        self._strategy = strategy
        self._batches: Batches | None = strategy.batches(space, folder.campaign.seed)
        self._has_begun = False
        self._points: list[Point] = []  # of the strategy, the next at the end
        self._repeats: list[Planned] = []  # of the last point, the next at the end
        self._again: list[Planned] = []
        self._open: dict[int, Point] = {}  # variants of the last batch of a strategy that learns
        self._results: defaultdict[int, list[Row]] = defaultdict(list)  # of these
        self._asked = self._variants = self._possible = self._impossible = 0
        self._continue(on_batch)

    # ------------------------------------------------------------ an earlier session

    def _continue(self, on_batch: Callable[[Batch], object]) -> None:
        """Plan what an earlier session has left, and bring the strategy to where it was."""
        ended = Numbers()
        for batch in read_batches(self._folder.folder):
            on_batch(batch)
            self._record_batch(batch)
            ended.update(batch.column("run"))
        last: Planned | None = None
        for last in self._folder.asked(ended):
            if last.number not in ended:
                self._again.append(last)
        if last is None:
            return
        self._asked = last.number
        point: Point | None = None
        for _ in range(last.variant):
            point = self._next_point()
        if point is None or dict(point.values) != dict(last.values):
            raise UsageError(
                f"{self._folder.folder} cannot be continued: the strategy `{self._strategy.name}` chooses other "
                "values than before"
            )
        self._repeats = self._planned(point)[: -last.repeat or None]

    # ------------------------------------------------------------ planning

    @property
    def is_over(self) -> bool:
        """Whether no more runs will be planned, unless some are returned."""
        has_more = self._batches is not None or self._points or self._repeats
        return not self._again and (not has_more or self._room() <= 0)

    def take(self, most: int) -> list[Planned]:
        """Plan the next runs, and note them in the folder.

        Args:
            most: Maximum number.

        Returns:
            The runs; empty at the end, and while the strategy needs results of earlier runs.
        """
        taken, self._again = self._again[:most], self._again[most:]
        new: list[Planned] = []
        while len(taken) + len(new) < most and (planned := self._next()) is not None:
            new.append(planned)
        if new:
            self._folder.ask(new)
        return taken + new

    def give_back(self, planned: Planned) -> None:
        """Plan a run again, whose worker has died."""
        self._again.append(planned)

    def record(self, row: Row) -> None:
        """Take the result of a run.

        Raises:
            UsageError: No run is possible.
        """
        if row.status is End.IMPOSSIBLE:
            self._impossible += 1
            if self._impossible >= MOST_IMPOSSIBLE and not self._possible:
                raise _nothing(f"all of the first {self._impossible:,} runs")
        else:
            self._possible += 1
        if self._strategy.is_learning:
            self._results[row.variant].append(row)

    def _record_batch(self, batch: Batch) -> None:
        if self._strategy.is_learning:
            for position in range(len(batch)):
                self.record(batch.row(position))
            return
        impossible = len(batch.ends.get(End.IMPOSSIBLE, ()))
        self._impossible += impossible
        self._possible += len(batch) - impossible

    def check_possible(self) -> None:
        """Raise `UsageError` if the campaign is over without a possible run."""
        if self.is_over and not self._possible:
            raise _nothing(f"all {self._impossible:,} runs" if self._impossible else "all values of the strategy")

    def _room(self) -> float:
        """Return how many more runs are wanted; impossible ones do not count."""
        runs = self._campaign.runs
        return math.inf if runs is None else runs - (self._asked - self._impossible)

    def _next(self) -> Planned | None:
        if self._room() <= 0:
            return None
        if not self._repeats:
            point = self._next_point()
            if point is None:
                return None
            self._repeats = self._planned(point)
        self._asked += 1
        return self._repeats.pop()

    def _planned(self, point: Point) -> list[Planned]:
        """Return the repeats of the last point, the first at the end."""
        campaign = self._campaign
        runs = runs_of(point, self._variants, self._strategy, campaign.seed, campaign.repeat, campaign.seeds)
        return runs[::-1]

    def _next_point(self) -> Point | None:
        """Return the next point of the strategy; None at its end, or if it needs results first."""
        while not self._points:
            batch = self._next_batch()
            if batch is None:
                return None
            self._points = list(reversed(batch))
        self._variants += 1
        point = self._points.pop()
        if self._strategy.is_learning:
            self._open[self._variants] = point
        return point

    def _next_batch(self) -> Sequence[Point] | None:
        if self._batches is None:
            return None
        try:
            if not self._has_begun or not self._strategy.is_learning:
                self._has_begun = True
                return next(self._batches)
            if any(len(self._results[variant]) < self._campaign.repeat for variant in self._open):
                return None
            told = [
                Told(point, tuple(sorted(self._results.pop(variant), key=lambda row: row.repeat)))
                for variant, point in self._open.items()
            ]
            self._open.clear()
            return self._batches.send(told)
        except StopIteration:
            self._batches = None
            return None


def runs_of(
    point: Point, variant: int, strategy: Strategy, seed: int, repeat: int, seeds: Sequence[int] = ()
) -> list[Planned]:
    """Return the planned runs of a point.

    Args:
        point: The point.
        variant: Its number, from 1.
        strategy: Strategy that asked for it.
        seed: Seed of the campaign.
        repeat: Number of its runs.
        seeds: Seeds of the repeats, which all points share; empty for consecutive ones.
    """
    first = (variant - 1) * repeat + 1
    start = seed + (first - 1 if strategy.sampling is not Sampling.NONE else 0)
    return [
        Planned(
            number=first + number,
            variant=variant,
            repeat=number + 1,
            seed=seeds[number] if seeds else start + number,
            values=point.values,
            strategy=f"{strategy.name}: {point.reason}" if point.reason else strategy.name,
            parent=point.parent,
        )
        for number in range(repeat)
    ]


def _nothing(what: str) -> UsageError:
    return UsageError(
        f"constraints exclude {what}",
        help="run the values of one with `seoro exec --set PATH=VALUE`, which names the constraints in conflict",
    )
