"""The way from a problem to its solution: what equalities say, then propagation, then choice, then z3."""

from __future__ import annotations

from collections import deque
from contextlib import suppress

from seoro.lang.solve.attempt import Contradiction, Engine, attempt, has_whole_arithmetic, store_of
from seoro.lang.solve.cells import Cell, Value
from seoro.lang.solve.conflict import smallest_conflict
from seoro.lang.solve.evaluation import evaluate
from seoro.lang.solve.parts import conjuncts
from seoro.lang.solve.problem import Conflict, Constraint, Problem, Solution, Unsolved
from seoro.lang.solve.propagate import Clash
from seoro.lang.solve.sets import contains, hull, natural
from seoro.lang.solve.terms import CellRef, Compare, Not, Term, Unevaluable


def solve(problem: Problem, seed: int, *, engine: Engine = "auto", explain: bool = True) -> Solution:
    """Give each cell a value such that all constraints hold.

    Args:
        problem: The cells and constraints.
        seed: What free choices are drawn from; the same problem and seed give the same values on any machine.
        engine: `auto` searches, and asks z3 where that does not decide; `search` does without z3; `z3` asks it for
            all that propagation leaves open.
        explain: Whether a conflict is made as small as possible, which may take longer than to find it.

    Raises:
        Conflict: Some constraints cannot all hold.
        Unbounded: A cell has nothing to draw its value from.
        NeedsSolver: z3 would have to decide, and is not installed.
        Undecided: Nobody could decide.
    """
    values = _by_equalities(problem)
    if values is not None:
        return Solution(values)
    # Values are sought among those for which no integer leaves its 64 bits, and only if there are none, among all.
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
    """A number below which a cell cannot be, whatever the others are: a lower bound, which may be no solution."""
    store = store_of(problem, wrapping=has_whole_arithmetic(problem))
    number = problem.cells.index(cell)
    with suppress(Clash):
        store.propagate(range(len(store.parts)))
    return hull(store.sets[number]).low


def follows(problem: Problem, term: Term) -> bool:
    """Whether the constraints of a problem are found to leave a condition no choice but to hold."""
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
    """The solution of a problem in which each cell is said to be equal to something known: that is most of them.

    Returns:
        None if this is not such a problem, or its constraints do not all hold.
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
    waiting: dict[Cell, list[tuple[Cell, Term]]] = {}  # rules by a cell that they need
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
    """Give a cell the value of a term.

    Returns:
        A cell whose value the term needs first; None if the value is known.
    """
    if cell not in values:
        try:
            values[cell] = evaluate(term, values)
        except KeyError as missing:
            needed = missing.args[0] if missing.args else cell
            return needed if isinstance(needed, Cell) else cell  # a function of others may lack anything
    return None
