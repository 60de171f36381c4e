"""One attempt at a problem: propagation, then search per group of cells, then z3.

A conflict is reduced to the smallest set of contradicting constraints, for people.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from itertools import combinations, islice
from math import comb
from typing import Final, Literal, TypeAlias

from seoro.lang.arithmetic import Number
from seoro.lang.solve.linear import solve_equations
from seoro.lang.solve.orders import impossible_order
from seoro.lang.solve.parts import parts_of
from seoro.lang.solve.problem import Conflict, Constraint, NeedsSolver, Problem, Unbounded, Undecided, Unsolved
from seoro.lang.solve.propagate import Clash, Store
from seoro.lang.solve.search import Exhausted, GivenUp, Streams, choose, groups, involved
from seoro.lang.solve.sets import natural, without_bounds
from seoro.lang.solve.terms import Arithmetic, Cell, Negate, ToWhole, Value, cells_of, subterms

Engine: TypeAlias = Literal["auto", "search", "z3"]


class Contradiction(Exception):
    """The constraints have no solution.

    Args:
        constraints: Numbers of contradicting constraints, possibly more than necessary.
        reason: Reason why one of them cannot be evaluated; may be empty.
        by_z3: Whether z3 found the contradiction.
    """

    def __init__(self, constraints: frozenset[int], reason: str, by_z3: bool) -> None:
        super().__init__(len(constraints))
        self.constraints = constraints
        self.reason = reason
        self.by_z3 = by_z3


def attempt(
    problem: Problem, seed: int, engine: Engine, *, wrapping: bool, relaxed: frozenset[Cell] = frozenset()
) -> dict[Cell, Value]:
    """Return values of all cells of a problem.

    Args:
        problem: The problem.
        seed: Seed of free choices.
        engine: Engine for cells that stay open after propagation; see `solve`.
        wrapping: Whether integers may exceed 64 bits and wrap.
        relaxed: Cells whose domains are ignored.

    Raises:
        Contradiction: The constraints have no solution.
        Unbounded, NeedsSolver, Undecided: See `solve`.
    """
    store = store_of(problem, wrapping, relaxed)
    together: frozenset[int] = frozenset()  # parts of the equations
    try:
        store.propagate(range(len(store.parts)))
        store.settle()
        together = solve_equations(store)
        streams = Streams(seed)
        for group in groups(store):
            _decide(store, group, streams, engine)
    except Unbounded:
        if cycle := impossible_order(store):
            raise _contradiction(store, cycle) from None
        raise
    except Clash as clash:
        raise _contradiction(store, frozenset(involved(store, clash.part)) | together) from None
    except Exhausted as exhausted:
        raise _contradiction(store, exhausted.parts | together, exhausted.by_z3) from None
    return store.values(range(len(problem.cells)))


def has_whole_arithmetic(problem: Problem) -> bool:
    """Return whether a problem has arithmetic of integers, whose results may exceed 64 bits."""
    return any(
        isinstance(term, Arithmetic | Negate | ToWhole) and term.number is not Number.FLOAT
        for constraint in problem.constraints
        for term in subterms(constraint.term)
    )


def store_of(problem: Problem, wrapping: bool, relaxed: frozenset[Cell] = frozenset()) -> Store:
    """Create the store of a problem, before propagation; see `attempt`."""
    numbers = {cell: number for number, cell in enumerate(problem.cells)}
    if len({cell.name for cell in problem.cells}) < len(problem.cells):
        names = [cell.name for cell in problem.cells]
        raise ValueError(f"two cells are named '{next(name for name in names if names.count(name) > 1)}'")
    sets = [without_bounds(cell) if cell in relaxed else natural(cell) for cell in problem.cells]
    return Store(problem.cells, parts_of(problem.constraints, numbers), sets, wrapping)


def _contradiction(store: Store, parts: frozenset[int], by_z3: bool = False) -> Contradiction:
    reason = next((store.remarks[part] for part in sorted(parts) if part in store.remarks), "")
    return Contradiction(frozenset(store.parts[part].source for part in parts), reason, by_z3)


def _decide(store: Store, group: list[int], streams: Streams, engine: Engine) -> None:
    """Choose values for the cells of a group."""
    cells = tuple(store.cells[cell] for cell in group)
    try:
        if engine != "z3":
            return choose(store, group, streams)
    except GivenUp:
        if engine == "search":
            raise Undecided(cells) from None
    if find_spec("z3") is None:
        raise NeedsSolver(cells)
    from seoro.lang.solve.smt import choose_with_z3  # noqa: PLC0415 - z3 is large, and rarely needed

    try:
        return choose_with_z3(store, group, streams)
    except GivenUp:
        raise Undecided(cells) from None


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
