"""Solution of systems of equalities such as `a + b == 10` and `a - b == 4` (Gaussian elimination, in fractions).

Propagation examines one constraint at a time, and finds no bounds in such a system. A system is solved only if a
number would be unbounded otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from heapq import heapify, heappop, heappush
from typing import Final

from seoro.lang.arithmetic import Number
from seoro.lang.solve import terms
from seoro.lang.solve.evaluation import evaluate
from seoro.lang.solve.propagate import Store
from seoro.lang.solve.search import Exhausted
from seoro.lang.solve.sets import MISSING, Empty, Range, hull, is_bounded, meet, only
from seoro.lang.solve.terms import Integer, Real

# Relative tolerance of a real that was solved for; less than `sets.NARROW`.
BAND: Final = 2e-13
# Limit of steps, which are changes of one factor; larger systems are left to the search. Chains take a few steps
# per equation; in dense systems, steps grow with the third power.
MOST_STEPS: Final = 5_000_000
CONSTANT: Final = -1  # column of the constant

Row = dict[int, Fraction]  # factors by cell; the sum with the constant is zero


def solve_equations(store: Store) -> frozenset[int]:
    """Narrow numbers without bounds by the equalities that determine them together.

    Returns:
        Numbers of the used parts; empty if no number was narrowed.

    Raises:
        Exhausted: The equalities contradict each other.
        Clash: The result contradicts another part.
    """
    if all(is_bounded(values) for values in store.sets if isinstance(values, Range)):
        return frozenset()
    rows = {number: row for number in range(len(store.parts)) if (row := _row(store, number)) is not None}
    used = frozenset(rows)
    if len(rows) < 2:
        return frozenset()
    try:
        reduced = _Elimination(store, used).reduce(rows.values())
    except TooManySteps:
        return frozenset()
    narrowed: list[int] = []
    for pivot, row in reduced:
        try:
            after = meet(store.sets[pivot], _values(store, pivot, row))
        except Empty:
            raise Exhausted(used) from None
        if after != store.sets[pivot]:
            store.narrow(pivot, after, min(used))
            narrowed.append(pivot)
    store.propagate(store.parts_of(narrowed))
    return used if narrowed else frozenset()


class TooManySteps(Exception):
    """A system takes more than `MOST_STEPS` steps."""


class _Elimination:
    """Solves each row for one cell, preferably without bounds, and eliminates the cell from the other rows.

    Args:
        store: The domains of the cells.
        used: Numbers of the parts of the rows.
    """

    def __init__(self, store: Store, used: frozenset[int]) -> None:
        self._store = store
        self._used = used
        self._solved: list[tuple[int, Row]] = []
        self._places: dict[int, int] = {}  # index in `_solved` of each pivot
        self.steps = 0

    def reduce(self, rows: Iterable[Row]) -> list[tuple[int, Row]]:
        """Solve the rows, forwards and then backwards.

        Returns:
            Cells with the rows that are solved for them.

        Raises:
            Exhausted: A row has no solution.
            TooManySteps: The limit is exceeded.
        """
        for row in rows:
            self._add(row)
        for place in range(len(self._solved) - 1, -1, -1):
            pivot, row = self._solved[place]
            for cell in [cell for cell in row if cell != pivot and cell in self._places]:
                self._eliminate(row, cell)  # the row of that cell has no other pivots any more
        return self._solved

    def _add(self, row: Row) -> None:
        """Eliminate the pivots of earlier rows, then solve the row for another cell."""
        waiting = [self._places[cell] for cell in row if cell in self._places]
        heapify(waiting)
        while waiting:
            pivot, other = self._solved[heappop(waiting)]
            if pivot in row:
                self._eliminate(row, pivot)
                for cell in other:
                    if cell != pivot and cell in self._places:
                        heappush(waiting, self._places[cell])
        columns = [cell for cell in row if cell != CONSTANT]
        if not columns:
            if row.get(CONSTANT):
                raise Exhausted(self._used)
            return
        pivot = min(columns, key=lambda cell: (is_bounded(self._store.sets[cell]), cell))
        factor = row[pivot]
        self._places[pivot] = len(self._solved)
        self._solved.append((pivot, {cell: value / factor for cell, value in row.items()}))

    def _eliminate(self, row: Row, pivot: int) -> None:
        """Eliminate a cell from a row by the row that is solved for it, in which its factor is one."""
        _, other = self._solved[self._places[pivot]]
        factor = row[pivot]
        self.steps += len(other)
        if self.steps > MOST_STEPS:
            raise TooManySteps
        for cell, value in other.items():
            changed = row.get(cell, Fraction(0)) - factor * value
            if changed:
                row[cell] = changed
            else:
                row.pop(cell, None)


def _values(store: Store, pivot: int, row: Row) -> Range:
    """Return the domain of a cell by the row that is solved for it.

    Raises:
        Empty: It contains no integer.
    """
    low = high = -row.get(CONSTANT, Fraction(0))
    for cell, factor in row.items():
        if cell in (pivot, CONSTANT):
            continue
        bounds = hull(store.sets[cell])
        if math.isinf(bounds.low) or math.isinf(bounds.high):
            return Range(-math.inf, math.inf)
        ends = sorted((-factor * Fraction(bounds.low), -factor * Fraction(bounds.high)))
        low, high = low + ends[0], high + ends[1]
    if isinstance(store.cells[pivot].domain, Integer):
        if math.ceil(low) > math.floor(high):
            raise Empty
        return Range(math.ceil(low), math.floor(high))
    least, most = float(low), float(high)
    return Range(least - BAND * abs(least), most + BAND * abs(most))


def _row(store: Store, number: int) -> Row | None:
    """Convert an equality of sums to a row; None for other parts. Known cells become constants."""
    term = store.parts[number].term
    if not isinstance(term, terms.Compare) or term.operator != "==" or number in store.entailed:
        return None
    row: Row = {}
    pending = [(term.left, Fraction(1)), (term.right, Fraction(-1))]
    try:
        while pending:
            current, factor = pending.pop()
            more = _summands(store, current, factor, row)
            if more is None:
                return None
            pending += more
    except (terms.Unevaluable, OverflowError, ValueError):  # invalid constant
        return None
    row = {cell: value for cell, value in row.items() if value}
    return row if any(cell != CONSTANT for cell in row) else None


def _summands(
    store: Store, term: terms.Term, factor: Fraction, row: Row
) -> list[tuple[terms.Term, Fraction]] | None:
    """Add a term times a factor to a row, or return its summands; None if it is not a sum."""
    constant = _constant(store, term)
    if constant is not None:
        row[CONSTANT] = row.get(CONSTANT, Fraction(0)) + factor * constant
        return []
    match term:
        case terms.CellRef(cell) if isinstance(cell.domain, Integer | Real):
            number = store.numbers[cell]
            row[number] = row.get(number, Fraction(0)) + factor
            return []
        case terms.ToReal(operand):
            return [(operand, factor)]
        case terms.ToWhole(operand) if not store.wrapping:
            return [(operand, factor)]
        case terms.Negate(operand, number) if number is Number.FLOAT or not store.wrapping:
            return [(operand, -factor)]
        case terms.Arithmetic(operator, left, right, number) if number is Number.FLOAT or not store.wrapping:
            if operator in ("+", "-"):
                return [(left, factor), (right, factor if operator == "+" else -factor)]
            one, other = _constant(store, left), _constant(store, right)
            if operator == "*" and (one is not None or other is not None):
                return [(right, factor * one)] if one is not None else [(left, factor * (other or 0))]
            if operator == "/" and number is Number.FLOAT and other:
                return [(left, factor / other)]
            return None
        case _:
            return None


def _constant(store: Store, term: terms.Term) -> Fraction | None:
    """Return the number that a term without open cells denotes, or None."""
    if isinstance(term, terms.CellRef):
        value = only(store.sets[store.numbers[term.cell]])
        return None if value is MISSING or not isinstance(value, int | float) else Fraction(value)
    if isinstance(term, terms.Arithmetic) and term.operator in ("+", "-"):
        return None  # its operands are examined one by one
    cells = terms.cells_of(term)
    values = {cell: only(store.sets[store.numbers[cell]]) for cell in cells}
    if any(value is MISSING for value in values.values()):
        return None
    value = evaluate(term, values)
    return Fraction(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
