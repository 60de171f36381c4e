"""Neighbourhood of a failed run: the strategy that changes one parameter at a time, until the run passes.

Each parameter goes away from its value in both directions, by one step, two, four, and so on, to its last value.
The steps are those of ladders. Then the distance at which the run passes first is bisected.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from typing import TypeAlias

from seoro.campaign.after.around_run import AroundRun
from seoro.campaign.after.ladders import Ladder, ladder_of
from seoro.campaign.after.same_failure import EXCLUDED, FAILS, SameFailure
from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis, Choices, Interval
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Told
from seoro.errors import UsageError

Endings: TypeAlias = Generator[Sequence[Point], Sequence[Told], list[str]]


class Direction:
    """Values of a parameter in one direction.

    Args:
        ladder: Ladder from the last value in this direction to that of the failed run.
    """

    def __init__(self, ladder: Ladder) -> None:
        self._ladder = ladder
        self._near = 0  # most steps at which it fails, without an end before
        self._far: int | None = None  # least steps at which it does not
        self.ending = ""  # of the run at `_far`

    @property
    def failing(self) -> str:
        """Furthest value at which the run fails."""
        return self._at(self._near)

    @property
    def end(self) -> str | None:
        """First value at which the run does not fail; None if it fails to the last one."""
        return None if self._far is None else self._at(self._far)

    def candidate(self) -> str | None:
        """Return the next value to try; None if the distance is known."""
        if self._far is None:
            return None if self._near == self._ladder.top else self._at(self._next)
        return self._at(self._next) if self._far - self._near > 1 else None

    def take(self, ending: str) -> None:
        """Take the ending of the run with the candidate."""
        if ending == FAILS:
            self._near = self._next
        else:
            self._far, self.ending = self._next, ending

    @property
    def _next(self) -> int:
        if self._far is None:
            return min(max(2 * self._near, 1), self._ladder.top)
        return (self._near + self._far) // 2

    def _at(self, steps: int) -> str:
        return self._ladder.at(self._ladder.top - steps)


Sides: TypeAlias = tuple[Direction | None, Direction | None]
"""Directions to the least and the greatest value; None if the failed run has this value."""


class Neighbourhood(AroundRun):
    """Strategy that changes one parameter of a failed run at a time; see `AroundRun`."""

    name = "neighbours"

    def __init__(self, run: int, values: Mapping[str, str], failure: SameFailure) -> None:
        super().__init__(run, values, failure)
        self.directions: dict[str, Sides] = {}  # of parameters whose values have an order
        self.others: dict[str, dict[str, str]] = {}  # of all others: endings of runs by value

    @property
    def has_repeated(self) -> bool:
        """Whether the run fails the same way when it is repeated."""
        return self.repeated is not None and self._failure.holds(self.repeated)

    def matters(self, path: str) -> bool:
        """Return whether the run does not fail the same way with some other value of a parameter."""
        sides = self.directions.get(path, ())
        ended = [each.ending for each in sides if each is not None and each.end is not None]
        endings = [*ended, *self.others.get(path, {}).values()]
        return any(ending not in (FAILS, EXCLUDED) for ending in endings)

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches; see `Strategy`."""
        axes = [axis for axis in space.axes if axis.path in self.values]
        if not axes:
            raise UsageError(f"run {self._run} has no parameter that varies")
        for axis in axes:
            given = self.values[axis.path]
            if isinstance(axis, Choices) and axis.numbers is None:
                self.others[axis.path] = {text: "" for text in axis.texts if text != given}
            else:
                low, high = (
                    Direction(ladder_of(axis, end, given)) if end != given else None for end in _ends(axis)
                )
                self.directions[axis.path] = low, high
        return self._batches(space)

    def _batches(self, space: Space) -> Batches:
        if not (yield from self._repeat()):
            return
        changes = [(path, text) for path, texts in self.others.items() for text in texts]
        endings = yield from self._try(space, changes)
        for (path, other), ending in zip(changes, endings, strict=True):
            self.others[path][other] = ending
        sides = [(path, each) for path, both in self.directions.items() for each in both if each is not None]
        while unknown := [(path, each, text) for path, each in sides if (text := each.candidate()) is not None]:
            changes = [(path, text) for path, _, text in unknown]
            for (_, each, _), ending in zip(unknown, (yield from self._try(space, changes)), strict=True):
                each.take(ending)

    def _try(self, space: Space, changes: Sequence[tuple[str, str]]) -> Endings:
        """Run the values with one change each; returns how these runs end."""
        points = [Point({**self.values, path: text}, f"{path}={text}", self._run) for path, text in changes]
        feasible = [point for point in points if space.is_feasible(point.values)]
        told = (yield feasible) if feasible else []
        endings = {id(point): self._failure.ending(each) for point, each in zip(feasible, told, strict=True)}
        return [endings.get(id(point), EXCLUDED) for point in points]


def _ends(axis: Axis) -> Sequence[str]:
    """Return the least and the greatest value of an axis."""
    if isinstance(axis, Interval):
        return axis.text(axis.low), axis.text(axis.high)
    assert axis.numbers is not None, "it has an order"
    order = sorted(zip(axis.numbers, axis.texts, strict=True))
    return order[0][1], order[-1][1]
