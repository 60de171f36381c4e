"""Coverage-directed runs: each run leads to the bin that lacks most of its target.

The constraints of the bin come to those of the scenario, and the solver draws values with them. Bins that
constraints exclude are left out, and so are bins that runs do not reach although their values are right.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence, Set
from heapq import heapify, heappop, heappush
from random import Random
from typing import ClassVar, Final, TypeAlias

from seoro.campaign.coverage.bins import Bin
from seoro.campaign.coverage.drawing import Excluded, InputSpace
from seoro.campaign.runs import End, Point, Row
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Sampling, Told
from seoro.errors import UsageError
from seoro.lang.frozen import Value

BATCH: Final = 64  # points between two looks at the coverage
TRIES: Final = 3  # runs with the values of a bin that have no sample in it, before it is left out
SEED_BITS: Final = 32

Key: TypeAlias = tuple[str, str]
"""Qualified item, and bucket."""


class Cover(Value):
    """Runs that fill the buckets of `cover` items over parameters, until each reachable one has its target."""

    name = "cover"
    is_learning = True
    is_endless = False
    sampling = Sampling.SPREAD
    helps: ClassVar[Mapping[str, str]] = {}

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the points; see `Strategy`."""
        inputs = space.inputs
        if inputs is None or not inputs.bins:
            raise UsageError(
                "the scenario has no `cover` item over its parameters, whose buckets runs could fill",
                help="add `cover(pace, unit: mps, range: [0..5], every: 1)`, or choose `--strategy random`",
            )
        return self._batches(space, inputs, Random(seed))  # noqa: S311 - not for secrets

    def _batches(self, space: Space, inputs: InputSpace, random: Random) -> Batches:
        goals = _Goals(inputs.bins)
        while wanted := _planned(goals, space, inputs, random):
            told = yield [point for point, _ in wanted]
            goals.learn(told, [goal for _, goal in wanted])


def _planned(goals: _Goals, space: Space, inputs: InputSpace, random: Random) -> list[tuple[Point, Bin]]:
    """Return the points of a batch, each with the bin that it leads to."""
    found: list[tuple[Point, Bin]] = []
    goals.begin()
    while len(found) < BATCH and (wanted := goals.next()) is not None:
        try:
            drawn = inputs.draw(wanted, random.getrandbits(SEED_BITS))
        except Excluded:
            goals.leave_out(wanted)
            continue
        others = (axis for axis in space.axes if axis.path not in drawn.values)
        values = {**drawn.values, **{axis.path: axis.at(random.random()) for axis in others}}
        goals.expect(wanted, drawn.samples)
        found.append((Point(values, f"{wanted.item} {wanted.bucket}"), wanted))
    return found


class _Goals:
    """Bins with their samples, and the expected samples of planned runs."""

    def __init__(self, bins: Sequence[Bin]) -> None:
        self._bins = bins
        self._numbers: dict[Key, int] = {(each.item, each.bucket): number for number, each in enumerate(bins)}
        self._left_out: set[int] = set()
        self._samples: Counter[int] = Counter()
        self._expected: Counter[int] = Counter()
        self._tries: Counter[int] = Counter()
        self._heap: list[tuple[float, int, int]] = []

    def begin(self) -> None:
        """Begin a batch."""
        self._expected.clear()
        self._heap = [self._rank(number) for number in range(len(self._bins)) if self._lack(number) > 0.0]
        heapify(self._heap)

    def next(self) -> Bin | None:
        """Return the bin that lacks most, combinations first, since these fill others, too; None without one."""
        while self._heap:
            lack, _, number = heappop(self._heap)
            now = self._lack(number)
            if now == -lack:
                return self._bins[number]
            if now > 0.0:
                heappush(self._heap, self._rank(number))
        return None

    def _rank(self, number: int) -> tuple[float, int, int]:
        return -self._lack(number), -self._bins[number].parts, number

    def _lack(self, number: int) -> float:
        """Return the missing share of the target of a bin."""
        if number in self._left_out:
            return 0.0
        wanted = self._bins[number].target
        return max(0.0, 1.0 - (self._samples[number] + self._expected[number]) / wanted)

    def leave_out(self, excluded: Bin) -> None:
        """Leave out a bin."""
        self._left_out.add(self._numbers[excluded.item, excluded.bucket])

    def expect(self, wanted: Bin, samples: Set[Key]) -> None:
        """Count the samples that a planned run will have.

        Args:
            wanted: The bin that it leads to.
            samples: The samples.
        """
        number = self._numbers[wanted.item, wanted.bucket]
        self._expected.update({number, *(self._numbers[key] for key in samples if key in self._numbers)})
        if self._lack(number) > 0.0:
            heappush(self._heap, self._rank(number))

    def learn(self, told: Sequence[Told], wanted: Sequence[Bin]) -> None:
        """Count the samples of the runs of a batch."""
        for each, goal in zip(told, wanted, strict=True):
            number = self._numbers[goal.item, goal.bucket]
            before = self._samples[number]
            for row in each.rows:
                if row.status in (End.PASSED, End.FAILED):
                    self._count(row)
            if self._samples[number] == before:
                self._tries[number] += 1
                if self._tries[number] >= TRIES:
                    self._left_out.add(number)

    def _count(self, row: Row) -> None:
        for plain in row.coverage:
            for bucket, count in plain["buckets"].items():
                number = self._numbers.get((plain["item"], bucket))
                if number is not None:
                    self._samples[number] += count
