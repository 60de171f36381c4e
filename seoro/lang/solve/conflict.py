"""From constraints that clash to the fewest that do, which is what people can act upon."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, islice
from math import comb
from typing import Final

from seoro.lang.solve.attempt import Contradiction, Engine, attempt
from seoro.lang.solve.cells import Cell
from seoro.lang.solve.problem import Conflict, Constraint, Problem, Unsolved
from seoro.lang.solve.terms import cells_of

# How many constraints may be looked at, counted each time, to make a conflict smaller.
EFFORT: Final = 5_000
# To ask z3 takes as long as to look at so many, however few they are.
Z3_EFFORT: Final = 60
# How many sets of one size are tried one by one.
SETS: Final = 400


class _Spent(Exception):
    """The effort is used up."""


class _Refutation:
    """Proves that constraints clash, and counts the effort."""

    def __init__(self, problem: Problem, engine: Engine, wrapping: bool) -> None:
        self._problem = problem
        self._engine: Engine = engine
        self._wrapping = wrapping
        self._effort = 0

    def pairs(self, numbers: frozenset[int]) -> Iterator[tuple[int, int]]:
        """Pairs of constraints that share a cell, of which one is among some numbers; not too many."""
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
        """Why these constraints clash, in numbers of the problem; None if they do not, or that is not known."""
        self._effort += len(numbers) + (Z3_EFFORT if self._engine == "z3" else 0)
        if self._effort > EFFORT:
            raise _Spent
        constraints = tuple(self._problem.constraints[number] for number in numbers)
        found = refutation(constraints, self._engine, self._wrapping)
        if found is None:
            return None
        return Contradiction(frozenset(numbers[index] for index in found.constraints), found.reason, found.by_z3)


def smallest_conflict(problem: Problem, found: Contradiction, wrapping: bool) -> Conflict:
    """The conflict to report: as small as bounded effort finds it, and never with a constraint to spare.

    Args:
        problem: The problem.
        found: Why it has no solution.
        wrapping: Whether integers may wrap.
    """
    engine: Engine = (
        "z3" if found.by_z3 else "search"
    )  # what search could not prove of all, it need not try of some
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
    """The cells whose domains are part of a conflict: without any one of them it is none."""
    cells = _cells(constraints)
    if refutation(constraints, engine, False, frozenset(cells)) is not None:
        return ()
    return tuple(cell for cell in cells if refutation(constraints, engine, False, frozenset({cell})) is None)


def _cells(constraints: tuple[Constraint, ...]) -> tuple[Cell, ...]:
    return tuple(dict.fromkeys(cell for constraint in constraints for cell in cells_of(constraint.term)))


def refutation(
    constraints: tuple[Constraint, ...], engine: Engine, wrapping: bool, relaxed: frozenset[Cell] = frozenset()
) -> Contradiction | None:
    """Why constraints clash, the domains of some cells aside; None if they do not, or nobody could tell."""
    try:
        attempt(Problem(_cells(constraints), constraints), 0, engine, wrapping=wrapping, relaxed=relaxed)
    except Contradiction as found:
        return found
    except Unsolved:
        return None
    return None


def _shrink(found: Contradiction, refute: _Refutation) -> Iterator[Contradiction]:
    """Ever smaller conflicts: what the proof used, then the smallest sets, then one constraint less at a time."""
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
        return  # all smaller sets can hold
    for number in numbers:
        if number in found.constraints:
            smaller = refute.of(tuple(sorted(found.constraints - {number})))
            if smaller is not None:
                found = smaller
                yield found


def _place(constraint: Constraint, number: int) -> tuple[str, int, int]:
    return constraint.span.file.name, constraint.span.start, number
