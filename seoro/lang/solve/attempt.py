"""One attempt at a problem: propagation, then search per group of cells, then z3."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Literal, TypeAlias

from seoro.lang.solve.cells import Cell, Value
from seoro.lang.solve.draw import Streams
from seoro.lang.solve.linear import solve_equations
from seoro.lang.solve.orders import impossible_order
from seoro.lang.solve.parts import parts_of
from seoro.lang.solve.problem import NeedsSolver, Problem, Unbounded, Undecided
from seoro.lang.solve.propagate import Clash, Store
from seoro.lang.solve.search import Exhausted, GivenUp, choose, groups, involved
from seoro.lang.solve.sets import natural, without_bounds
from seoro.lang.solve.terms import Arithmetic, Negate, Number, ToWhole, subterms

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
