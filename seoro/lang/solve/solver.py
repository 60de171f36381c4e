"""Entry points: solution of a problem by equalities, propagation, search and z3; bounds, and implications."""

from __future__ import annotations

from collections import deque
from contextlib import suppress

from seoro.lang.solve.attempt import (
    Contradiction,
    Engine,
    attempt,
    has_whole_arithmetic,
    smallest_conflict,
    store_of,
)
from seoro.lang.solve.evaluation import evaluate
from seoro.lang.solve.parts import conjuncts
from seoro.lang.solve.problem import Conflict, Constraint, Problem, Solution, Unsolved
from seoro.lang.solve.propagate import Clash
from seoro.lang.solve.sets import contains, hull, natural
from seoro.lang.solve.terms import Cell, CellRef, Compare, Not, Term, Unevaluable, Value


def solve(problem: Problem, seed: int, *, engine: Engine = "auto", explain: bool = True) -> Solution:
    """Return a value of each cell such that all constraints hold.

    Args:
        problem: The cells and constraints.
        seed: Seed of free choices; equal problems and seeds result in equal values on any machine.
        engine: `auto` searches, and uses z3 if the search is undecided; `search` uses no z3; `z3` uses no search.
        explain: Whether to reduce a conflict, which may take longer than finding it.

    Raises:
        Conflict: Some constraints cannot all hold.
        Unbounded: A cell without bounds cannot be drawn.
        NeedsSolver: The search is undecided, and z3 is not installed.
        Undecided: All engines are undecided.
    """
    values = _by_equalities(problem)
    if values is not None:
        return Solution(values)
    # Integers wrap only if no solution stays within 64 bits.
    try:
        return Solution(attempt(problem, seed, engine, wrapping=False))
    except Contradiction as contradiction:
        found, wrapping = contradiction, False
    if has_whole_arithmetic(problem):
        try:
            return Solution(attempt(problem, seed, "search", wrapping=True))
        except Contradiction as contradiction:
            found, wrapping = contradiction, True
        except Unsolved:
            pass
    if explain:
        raise smallest_conflict(problem, found, wrapping)
    raise Conflict(tuple(problem.constraints[number] for number in sorted(found.constraints)), (), found.reason)


def lowest(problem: Problem, cell: Cell) -> float:
    """Return a lower bound of a cell, which may have no solution."""
    store = store_of(problem, wrapping=has_whole_arithmetic(problem))
    number = problem.cells.index(cell)
    with suppress(Clash):
        store.propagate(range(len(store.parts)))
    return hull(store.sets[number]).low


def follows(problem: Problem, term: Term) -> bool:
    """Return whether propagation proves that the constraints of a problem imply a condition."""
    refuted = Constraint(Not(term), problem.cells[0].span, "") if problem.cells else None
    if refuted is None:
        return False
    opposite = Problem(problem.cells, (*problem.constraints, refuted))
    store = store_of(opposite, wrapping=has_whole_arithmetic(problem))
    try:
        store.propagate(range(len(store.parts)))
    except Clash:
        return True
    return False


def _by_equalities(problem: Problem) -> dict[Cell, Value] | None:
    """Return the solution if equalities determine each cell, as in most problems.

    Returns:
        None for other problems, and if a constraint does not hold.
    """
    rules: deque[tuple[Cell, Term]] = deque()
    for constraint in problem.constraints:
        for term in conjuncts(constraint.term):
            if isinstance(term, Compare) and term.operator == "==":
                if isinstance(term.left, CellRef):
                    rules.append((term.left.cell, term.right))
                if isinstance(term.right, CellRef):
                    rules.append((term.right.cell, term.left))
    values: dict[Cell, Value] = {}
    waiting: dict[Cell, list[tuple[Cell, Term]]] = {}  # rules by a required cell
    try:
        while rules:
            cell, term = rules.popleft()
            needed = _follow(cell, term, values)
            if needed is not None:
                waiting.setdefault(needed, []).append((cell, term))
            else:
                rules.extend(waiting.pop(cell, ()))
        if len(values) < len(problem.cells):
            return None
        if not all(evaluate(constraint.term, values) is True for constraint in problem.constraints):
            return None
    except Unevaluable:
        return None
    ordered = {cell: values[cell] for cell in problem.cells}
    return ordered if all(contains(natural(cell), value) for cell, value in ordered.items()) else None


def _follow(cell: Cell, term: Term, values: dict[Cell, Value]) -> Cell | None:
    """Assign the value of a term to a cell.

    Returns:
        A cell that the term requires; None if its value is known.
    """
    if cell not in values:
        try:
            values[cell] = evaluate(term, values)
        except KeyError as missing:
            needed = missing.args[0] if missing.args else cell
            return needed if isinstance(needed, Cell) else cell  # raised by an opaque function
    return None
