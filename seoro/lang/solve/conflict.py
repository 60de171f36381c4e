"""Reduction of a conflict to the smallest set of contradicting constraints, for people."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, islice
from math import comb
from typing import Final

from seoro.lang.solve.attempt import Contradiction, Engine, attempt
from seoro.lang.solve.cells import Cell
from seoro.lang.solve.problem import Conflict, Constraint, Problem, Unsolved
from seoro.lang.solve.terms import cells_of

# Limit of the effort to reduce a conflict [examined constraints].
EFFORT: Final = 5_000
# Effort of a check by z3 [examined constraints].
Z3_EFFORT: Final = 60
# Limit of sets of one size that are tried.
SETS: Final = 400


class _Spent(Exception):
    """The effort has reached its limit."""


class _Refutation:
    """Finds contradictions among constraints, and counts the effort."""

    def __init__(self, problem: Problem, engine: Engine, wrapping: bool) -> None:
        self._problem = problem
        self._engine: Engine = engine
        self._wrapping = wrapping
        self._effort = 0

    def pairs(self, numbers: frozenset[int]) -> Iterator[tuple[int, int]]:
        """Yield pairs of constraints that share a cell, at least one of them among `numbers`; at most `SETS`."""
        users: dict[Cell, list[int]] = {}
        for number, constraint in enumerate(self._problem.constraints):
            for cell in cells_of(constraint.term):
                users.setdefault(cell, []).append(number)
        found = (
            (min(number, other), max(number, other))
            for number in sorted(numbers)
            for cell in cells_of(self._problem.constraints[number].term)
            for other in users[cell]
            if other != number
        )
        return islice(dict.fromkeys(found), SETS)

    def of(self, numbers: tuple[int, ...]) -> Contradiction | None:
        """Find the contradiction among constraints of the problem; None if none is found."""
        self._effort += len(numbers) + (Z3_EFFORT if self._engine == "z3" else 0)
        if self._effort > EFFORT:
            raise _Spent
        constraints = tuple(self._problem.constraints[number] for number in numbers)
        found = refutation(constraints, self._engine, self._wrapping)
        if found is None:
            return None
        return Contradiction(frozenset(numbers[index] for index in found.constraints), found.reason, found.by_z3)


def smallest_conflict(problem: Problem, found: Contradiction, wrapping: bool) -> Conflict:
    """Return the conflict to report, reduced as far as the limit of the effort allows.

    Args:
        problem: The problem.
        found: A contradiction in it.
        wrapping: Whether integers may wrap.
    """
    engine: Engine = "z3" if found.by_z3 else "search"  # search cannot refute subsets if it cannot refute all
    refute = _Refutation(problem, engine, wrapping)
    best = found
    try:
        for smaller in _shrink(found, refute):
            best = smaller
    except _Spent:
        pass
    numbers = sorted(best.constraints, key=lambda number: _place(problem.constraints[number], number))
    constraints = tuple(problem.constraints[number] for number in numbers)
    return Conflict(constraints, _limits(constraints, engine), best.reason)


def _limits(constraints: tuple[Constraint, ...], engine: Engine) -> tuple[Cell, ...]:
    """Return the cells whose domains are necessary for a conflict."""
    cells = _cells(constraints)
    if refutation(constraints, engine, False, frozenset(cells)) is not None:
        return ()
    return tuple(cell for cell in cells if refutation(constraints, engine, False, frozenset({cell})) is None)


def _cells(constraints: tuple[Constraint, ...]) -> tuple[Cell, ...]:
    return tuple(dict.fromkeys(cell for constraint in constraints for cell in cells_of(constraint.term)))


def refutation(
    constraints: tuple[Constraint, ...], engine: Engine, wrapping: bool, relaxed: frozenset[Cell] = frozenset()
) -> Contradiction | None:
    """Find a contradiction among constraints, with some domains ignored; None if none is found."""
    try:
        attempt(Problem(_cells(constraints), constraints), 0, engine, wrapping=wrapping, relaxed=relaxed)
    except Contradiction as found:
        return found
    except Unsolved:
        return None
    return None


def _shrink(found: Contradiction, refute: _Refutation) -> Iterator[Contradiction]:
    """Yield smaller and smaller conflicts: from the proof, the smallest sets, then by single constraints."""
    while (again := refute.of(tuple(sorted(found.constraints)))) and len(again.constraints) < len(
        found.constraints
    ):
        found = again
        yield found
    for pair in refute.pairs(found.constraints):
        if len(found.constraints) > 2 and (smallest := refute.of(pair)) is not None:
            found = smallest
            yield found
    numbers = tuple(sorted(found.constraints))
    for size in range(1, len(numbers)):
        if comb(len(numbers), size) > SETS:
            break
        for some in combinations(numbers, size):
            if (smallest := refute.of(some)) is not None:
                yield smallest
                return
    else:
        return  # all smaller sets have solutions
    for number in numbers:
        if number in found.constraints:
            smaller = refute.of(tuple(sorted(found.constraints - {number})))
            if smaller is not None:
                found = smaller
                yield found


def _place(constraint: Constraint, number: int) -> tuple[str, int, int]:
    return constraint.span.file.name, constraint.span.start, number
