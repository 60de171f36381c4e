"""Helpers to write problems."""

from __future__ import annotations

from typing import cast

from seoro.lang.arithmetic import Number
from seoro.lang.solve import Cell, Constraint, Domain, Problem, Value
from seoro.lang.solve.terms import (
    Arithmetic,
    CellRef,
    Compare,
    Const,
    InRange,
    InSet,
    Operation,
    Relation,
    Term,
    cells_of,
)
from seoro.lang.source import SourceFile, Span

FILE = SourceFile("test.osc", "")
INT, UINT, FLOAT = Number.INT, Number.UINT, Number.FLOAT

Operand = Term | Cell | bool | int | float | str


def cell(name: str, domain: Domain) -> Cell:
    """Return a cell with a declaration."""
    return Cell(name, Span(FILE, 0, 1), domain)


def term(operand: Operand) -> Term:
    """Return a cell or a constant as a term."""
    if isinstance(operand, Cell):
        return CellRef(operand)
    return Const(operand) if isinstance(operand, bool | int | float | str) else operand


def compare(left: Operand, relation: str, right: Operand) -> Compare:
    """Return a comparison."""
    return Compare(cast(Relation, relation), term(left), term(right))


def calculate(left: Operand, operation: str, right: Operand, number: Number = INT) -> Arithmetic:
    """Return an operation."""
    return Arithmetic(cast(Operation, operation), term(left), term(right), number)


def within(item: Operand, low: Operand, high: Operand) -> InRange:
    """Return the membership of a range."""
    return InRange(term(item), term(low), term(high))


def among(item: Operand, *values: Value) -> InSet:
    """Return the membership of a list."""
    return InSet(term(item), values)


def keep(what: Term, text: str = "", place: int = 0) -> Constraint:
    """Return a constraint."""
    return Constraint(what, Span(FILE, place, place + 1), text)


def problem(*terms: Term, cells: tuple[Cell, ...] = ()) -> Problem:
    """Return a problem of constraints `0`, `1`, ... in source order, over their cells and others."""
    found = dict.fromkeys((*cells, *(cell for what in terms for cell in cells_of(what))))
    return Problem(tuple(found), tuple(keep(what, str(place), place) for place, what in enumerate(terms)))
