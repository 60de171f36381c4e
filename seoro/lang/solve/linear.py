"""Numbers that equalities determine together: `a + b == 10` and `a - b == 4` (Gauss and Jordan, in fractions).

Propagation looks at one constraint at a time, and finds no bounds in such a system. It is solved where a number
would be unbounded otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Final

from seoro.lang.solve.cells import Integer, Real
from seoro.lang.solve.evaluation import evaluate
from seoro.lang.solve.propagate import Store
from seoro.lang.solve.search import Exhausted
from seoro.lang.solve.sets import MISSING, Empty, Range, hull, is_bounded, meet, only
from seoro.lang.solve.terms import (
    Arithmetic,
    CellRef,
    Compare,
    Negate,
    Number,
    Term,
    ToReal,
    ToWhole,
    Unevaluable,
    cells_of,
)

# How far a real that was solved for may be from where it should be, relative to it: less than `sets.NARROW`.
BAND: Final = 2e-13
# Systems with more equations than this are left to the search: effort grows with the third power.
MOST: Final = 300
CONSTANT: Final = -1  # the column of what does not depend on cells

Row = dict[int, Fraction]  # factors by numbers of cells; their sum with the constant is zero


def solve_equations(store: Store) -> frozenset[int]:
    """Narrow numbers without bounds by the equalities that determine them together.

    Returns:
        Numbers of the parts that this took; empty if no number was narrowed.

    Raises:
        Exhausted: The equalities contradict each other.
        Clash: What follows from them contradicts another part.
    """
    if all(is_bounded(values) for values in store.sets if isinstance(values, Range)):
        return frozenset()
    rows = {number: row for number in range(len(store.parts)) if (row := _row(store, number)) is not None}
    used = frozenset(rows)
    if not 2 <= len(rows) <= MOST:
        return frozenset()
    narrowed: list[int] = []
    for pivot, row in _reduced(store, list(rows.values())):
        try:
            after = meet(store.sets[pivot], _values(store, pivot, row))
        except Empty:
            raise Exhausted(used) from None
        if after != store.sets[pivot]:
            store.narrow(pivot, after, min(used))
            narrowed.append(pivot)
    store.propagate(store.parts_of(narrowed))
    return used if narrowed else frozenset()


def _reduced(store: Store, rows: list[Row]) -> Iterator[tuple[int, Row]]:
    """Each row solved for one cell, if possible for one without bounds, which no other row mentions then.

    Raises:
        Exhausted: A row has no solution.
    """
    done: list[tuple[int, Row]] = []
    for row in rows:
        for pivot, other in done:
            _eliminate(row, pivot, other)
        columns = [cell for cell in row if cell != CONSTANT]
        if not columns:
            if row.get(CONSTANT):
                raise Exhausted(frozenset(number for number in range(len(store.parts)) if _row(store, number)))
            continue
        pivot = min(columns, key=lambda cell: (is_bounded(store.sets[cell]), cell))
        factor = row[pivot]
        solved = {cell: value / factor for cell, value in row.items()}
        for _, other in done:
            _eliminate(other, pivot, solved)
        done.append((pivot, solved))
    yield from done


def _eliminate(row: Row, pivot: int, other: Row) -> None:
    """Take a cell out of a row by another row, in which its factor is one."""
    factor = row.get(pivot)
    if not factor:
        return
    for cell, value in other.items():
        changed = row.get(cell, Fraction(0)) - factor * value
        if changed:
            row[cell] = changed
        else:
            row.pop(cell, None)


def _values(store: Store, pivot: int, row: Row) -> Range:
    """Return the domain of a cell by the row that is solved for it.

    Raises:
        Empty: No whole number.
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
    """A part as a row, if it is an equality of sums of numbers; cells with values are part of the constant."""
    term = store.parts[number].term
    if not isinstance(term, Compare) or term.operator != "==" or number in store.entailed:
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
    except (Unevaluable, OverflowError, ValueError):  # a constant that is not a number
        return None
    row = {cell: value for cell, value in row.items() if value}
    return row if any(cell != CONSTANT for cell in row) else None


def _summands(store: Store, term: Term, factor: Fraction, row: Row) -> list[tuple[Term, Fraction]] | None:
    """Add a term times a factor to a row, or return its summands; None if it is not a sum."""
    constant = _constant(store, term)
    if constant is not None:
        row[CONSTANT] = row.get(CONSTANT, Fraction(0)) + factor * constant
        return []
    match term:
        case CellRef(cell) if isinstance(cell.domain, Integer | Real):
            number = store.cells.index(cell)
            row[number] = row.get(number, Fraction(0)) + factor
            return []
        case ToReal(operand):
            return [(operand, factor)]
        case ToWhole(operand) if not store.wrapping:
            return [(operand, factor)]
        case Negate(operand, number) if number is Number.FLOAT or not store.wrapping:
            return [(operand, -factor)]
        case Arithmetic(operator, left, right, number) if number is Number.FLOAT or not store.wrapping:
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


def _constant(store: Store, term: Term) -> Fraction | None:
    """The value of a term that is a number and depends on no open cell."""
    if isinstance(term, CellRef):
        value = only(store.sets[store.cells.index(term.cell)])
        return None if value is MISSING or not isinstance(value, int | float) else Fraction(value)
    if isinstance(term, Arithmetic) and term.operator in ("+", "-"):
        return None  # whose operands are looked at one by one
    cells = cells_of(term)
    values = {cell: only(store.sets[store.cells.index(cell)]) for cell in cells}
    if any(value is MISSING for value in values.values()):
        return None
    value = evaluate(term, values)
    return Fraction(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
