"""Detection of cyclic orders such as `a < b`, `b < c`, `c < a`.

Propagation would narrow such cells number by number, endlessly without bounds. Differences `x - y <= d` are edges
of a graph, in which a cycle of negative length is a contradiction (Bellman and Ford).
"""

from __future__ import annotations

from typing import Final, NamedTuple

from seoro.lang.arithmetic import Number
from seoro.lang.solve import terms
from seoro.lang.solve.parts import Part
from seoro.lang.solve.propagate import Store
from seoro.lang.solve.terms import Cell, Integer, Real

# Limit of the length of a cycle of reals, relative to its edges, that is more than rounding.
CERTAIN: Final = 1e-9


class _Length(NamedTuple):
    """A difference, ordered by value, then by the number of strict comparisons of reals."""

    value: float
    strict: int = 0


class _Edge(NamedTuple):
    """`to` - `start` <= length."""

    start: int
    to: int
    length: _Length
    part: int


def impossible_order(store: Store) -> frozenset[int]:
    """Return the numbers of parts that form a cyclic order; empty without one."""
    edges = [edge for number, part in enumerate(store.parts) for edge in _edges(store, number, part)]
    distance = [_Length(0)] * len(store.cells)
    reached: dict[int, _Edge] = {}
    last = -1
    for _ in range(len(store.cells) + 1):
        last = -1
        for edge in edges:
            before = distance[edge.start]
            length = _Length(before.value + edge.length.value, before.strict + edge.length.strict)
            if length < distance[edge.to]:
                distance[edge.to] = length
                reached[edge.to] = edge
                last = edge.to
        if last < 0:
            return frozenset()
    circle = _circle(last, reached, len(store.cells))
    total = sum(edge.length.value for edge in circle)
    scale = sum(abs(edge.length.value) for edge in circle)
    certain = total <= -CERTAIN * scale if scale else True
    return frozenset(edge.part for edge in circle) if certain else frozenset()


def _circle(cell: int, reached: dict[int, _Edge], count: int) -> list[_Edge]:
    """Return the cycle of a cell whose distance shrank in every round."""
    for _ in range(count):
        cell = reached[cell].start
    circle = [reached[cell]]
    while circle[-1].start != cell:
        circle.append(reached[circle[-1].start])
    return circle


def _edges(store: Store, number: int, part: Part) -> list[_Edge]:
    """Return the edges of a comparison of two cells; empty for other parts."""
    term = part.term
    if not isinstance(term, terms.Compare) or term.operator == "!=" or not 1 <= len(part.cells) <= 2:
        return []
    difference = _Sum()
    if not (difference.add(term.left, 1, store.wrapping) and difference.add(term.right, -1, store.wrapping)):
        return []
    numbers = {store.cells[cell]: cell for cell in part.cells}
    factors = {numbers[cell]: factor for cell, factor in difference.factors.items() if factor}
    if factors and sorted(factors.values()) != [-1, 1]:
        return []
    # high - low + constant <relation> 0; a cell that cancels out becomes both
    high, low = sorted(factors, key=factors.__getitem__, reverse=True) if factors else (part.cells[0],) * 2
    return _both_ways(term.operator, low, high, difference, number)


def _both_ways(relation: terms.Relation, low: int, high: int, difference: _Sum, number: int) -> list[_Edge]:
    """Return the edges of `high - low + constant <relation> 0`."""
    constant = difference.constant
    step = _Length(-1) if difference.whole else _Length(0, -1)
    edges = []
    if relation in ("<", "<=", "=="):
        strict = step if relation == "<" else _Length(0)
        edges.append(_Edge(low, high, _Length(strict.value - constant, strict.strict), number))
    if relation in (">", ">=", "=="):
        strict = step if relation == ">" else _Length(0)
        edges.append(_Edge(high, low, _Length(strict.value + constant, strict.strict), number))
    return edges


class _Sum:
    """A sum of cells and a constant, collected from terms."""

    def __init__(self) -> None:
        self.factors: dict[Cell, int] = {}
        self.constant: float = 0
        self.whole = True

    def add(self, term: terms.Term, sign: int, wrapping: bool) -> bool:
        """Add a term times a sign; return False for other terms, and for results that may exceed 64 bits."""
        pending = [(term, sign)]
        while pending:
            current, sign = pending.pop()
            match current:
                case terms.Const(value) if isinstance(value, int | float) and not isinstance(value, bool):
                    self.constant += sign * value
                    self.whole = self.whole and isinstance(value, int)
                case terms.CellRef(cell) if isinstance(cell.domain, Integer | Real):
                    self.whole = self.whole and not isinstance(cell.domain, Real)
                    self.factors[cell] = self.factors.get(cell, 0) + sign
                case terms.ToReal(operand):
                    pending.append((operand, sign))
                case terms.ToWhole(operand) if not wrapping:
                    pending.append((operand, sign))
                case terms.Negate(operand, number) if number is Number.FLOAT or not wrapping:
                    pending.append((operand, -sign))
                case terms.Arithmetic("+" | "-" as operator, left, right, number) if (
                    number is Number.FLOAT or not wrapping
                ):
                    pending += [(right, sign if operator == "+" else -sign), (left, sign)]
                case _:
                    return False
        return True
