"""Shrinking: the strategy that makes the values of a failed run simpler, as long as it fails the same way.

It tries the simplest value of each parameter, then halves the distance of the others to it, until no parameter can
be one step simpler. It is delta debugging (Zeller and Hildebrandt, "Simplifying and isolating failure-inducing
input", 2002) on parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from enum import Enum
from typing import TypeAlias

from seoro.campaign.after.around_run import AroundRun
from seoro.campaign.after.descent import Descent
from seoro.campaign.after.ladders import ladder_of, simplest_of
from seoro.campaign.after.same_failure import SameFailure
from seoro.campaign.runs import Point
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Batches, Told
from seoro.errors import UsageError

Values: TypeAlias = dict[str, str]
"""Values of parameters by path, in the notation of the scenario."""

Trying: TypeAlias = Generator[Sequence[Point], Sequence[Told], list[bool]]
Adopting: TypeAlias = Generator[Sequence[Point], Sequence[Told], list[int]]


class Outcome(Enum):
    """State of shrinking."""

    UNCONFIRMED = "unconfirmed"  # the run was not repeated yet
    GONE = "gone"  # the repeated run passes, or fails in another way
    FAILING = "failing"  # the values fail; there may be simpler ones
    MINIMAL = "minimal"  # no parameter can be one step simpler


class Shrinking(AroundRun):
    """Strategy that shrinks one failed run, and keeps its failure; see `AroundRun`."""

    name = "shrink"

    def __init__(self, run: int, values: Mapping[str, str], failure: SameFailure) -> None:
        super().__init__(run, values, failure)
        self._known: dict[frozenset[tuple[str, str]], bool] = {}
        self._runs: dict[frozenset[tuple[str, str]], int] = {}  # first run with values that fail
        self._is_feasible: Callable[[Mapping[str, str]], bool] = lambda _: True
        self.simplest: Values = {}
        self.outcome = Outcome.UNCONFIRMED

    @property
    def best(self) -> int:
        """Number of the run with the present values, in the campaign that shrinks."""
        return self._runs[frozenset(self.values.items())]

    def batches(self, space: Space, seed: int) -> Batches:
        """Return the batches; see `Strategy`."""
        axes = {axis.path: axis for axis in space.axes if axis.path in self.values}
        if not axes:
            raise UsageError(f"run {self._run} has no parameter that varies")
        self._is_feasible = space.is_feasible
        self.simplest = {path: simplest_of(axis, space.usual.get(path)) for path, axis in axes.items()}
        ladders = {path: ladder_of(axis, self.simplest[path], self.values[path]) for path, axis in axes.items()}
        return self._batches({path: Descent(ladder) for path, ladder in ladders.items()})

    def _batches(self, descents: Mapping[str, Descent]) -> Batches:
        if not (yield from self._repeat()):
            self.outcome = Outcome.GONE
            return
        assert self.repeated is not None, "the run was repeated"
        self._learn(frozenset(self.values.items()), self.repeated)
        self.outcome = Outcome.FAILING
        before: Values = {}
        while before != self.values:
            before = dict(self.values)
            yield from self._simplify(descents)
            yield from self._descend(descents)
            for descent in descents.values():
                descent.reopen()
        self.outcome = Outcome.MINIMAL

    def _simplify(self, descents: Mapping[str, Descent]) -> Batches:
        """Try the simplest values of all parameters together, and of each."""
        moves = [{path: text} for path, text in self.simplest.items() if self.values[path] != text]
        together = {path: text for move in moves for path, text in move.items()}
        fails = yield from self._try([together, *moves])
        failing = [move for move, does in zip(moves, fails[1:], strict=True) if does]
        yield from self._adopt([together] if fails[0] else failing)
        for path, descent in descents.items():
            if self.values[path] == self.simplest[path]:
                descent.simplify()

    def _descend(self, descents: Mapping[str, Descent]) -> Batches:
        """Halve the distance of all parameters to their simplest values, at the same time."""
        while True:
            moves = {path: text for path, descent in descents.items() if (text := descent.candidate()) is not None}
            if not moves:
                return
            fails = yield from self._try([{path: text} for path, text in moves.items()])
            failing = [path for path, does in zip(moves, fails, strict=True) if does]
            for path in moves.keys() - failing:
                descents[path].reject()
            for index in (yield from self._adopt([{path: moves[path]} for path in failing])):
                descents[failing[index]].accept()

    def _adopt(self, moves: Sequence[Values]) -> Adopting:
        """Adopt changes that fail alone, together or one after another; returns the numbers of adopted ones."""
        together = {path: text for move in moves for path, text in move.items()}
        if len(moves) > 1 and (yield from self._try([together]))[0]:
            self.values.update(together)
            return list(range(len(moves)))
        adopted: list[int] = []
        for number, move in enumerate(moves):
            if not adopted or (yield from self._try([move]))[0]:
                self.values.update(move)
                adopted.append(number)
        return adopted

    def _try(self, moves: Sequence[Values]) -> Trying:
        """Run changes of the present values; returns which of them fail the same way."""
        keys = [frozenset({**self.values, **move}.items()) for move in moves]
        points: dict[frozenset[tuple[str, str]], Point] = {}
        for key, move in zip(keys, moves, strict=True):
            values = {**self.values, **move}
            if key not in self._known and key not in points and self._is_feasible(values):
                reason = " ".join(f"{path}={text}" for path, text in move.items())
                points[key] = Point(values, reason, self._run)
        if points:
            told = yield list(points.values())
            for key, each in zip(points, told, strict=True):
                self._learn(key, each)
        return [self._known.get(key, False) for key in keys]

    def _learn(self, key: frozenset[tuple[str, str]], told: Told) -> None:
        self._known[key] = self._failure.holds(told)
        if self._known[key]:
            self._runs[key] = told.rows[0].run
