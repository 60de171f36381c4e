"""Constraints as propagation works on them: split at `and`, terms laid out in a row, cells by number."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from seoro.lang import frozen
from seoro.lang.solve.cells import Cell
from seoro.lang.solve.problem import Constraint
from seoro.lang.solve.sets import ANYTHING, ValueSet, single
from seoro.lang.solve.terms import (
    And,
    Arithmetic,
    CellRef,
    Compare,
    Const,
    IfThenElse,
    Implies,
    Negate,
    Number,
    Opaque,
    Or,
    Term,
    ToWhole,
    cells_of,
    operands,
)


class Node(frozen.Frozen):
    """One term of a part.

    Args:
        term: The term.
        args: Where its operands are in the row.
        cell: Number of the cell that it is, or -1.
        constant: Its value, if it is a constant.
    """

    term: Term
    args: tuple[int, ...]
    cell: int
    constant: ValueSet


class Part(frozen.Frozen):
    """A constraint, or one member of a conjunction that is one.

    Args:
        source: Number of the constraint.
        term: What has to hold.
        nodes: Its terms, operands first; the last is the whole.
        cells: Numbers of its cells.
        solvable: Those of which the others leave one value, because the part is an equality that can be undone.
        definitions: Cells that the part says to be equal to something that they have no part in, and what that is.
        partial: Whether it may have no value, whatever its terms can be.
        listed: Whether contraction of the last open cell may leave values that do not satisfy it.
        cost: How long it takes to evaluate it, in terms.
    """

    source: int
    term: Term
    nodes: tuple[Node, ...]
    cells: tuple[int, ...]
    solvable: tuple[int, ...]
    definitions: tuple[tuple[int, Term], ...]
    partial: bool
    listed: bool
    cost: int


def parts_of(constraints: tuple[Constraint, ...], numbers: Mapping[Cell, int]) -> tuple[Part, ...]:
    """The parts of all constraints, in their order."""
    return tuple(
        _part(source, term, numbers)
        for source, constraint in enumerate(constraints)
        for term in conjuncts(constraint.term)
    )


def conjuncts(term: Term) -> Iterator[Term]:
    """The members of a conjunction, however nested, or the term itself."""
    todo = [term]
    while todo:
        current = todo.pop()
        if isinstance(current, And):
            todo.extend(reversed(current.operands))
        else:
            yield current


def _part(source: int, term: Term, numbers: Mapping[Cell, int]) -> Part:
    nodes = _row(term, numbers)
    mentioned = [cell for node in nodes for cell in _cells(node, numbers)]
    cells = tuple(dict.fromkeys(mentioned))
    repeated = len(mentioned) > len(cells)
    partial = any(_is_partial(node.term) for node in nodes)
    listed = repeated or any(_is_coarse(node.term) for node in nodes)
    solvable = () if repeated else _solvable(term, numbers)
    cost = sum(node.term.cost if isinstance(node.term, Opaque) else 1 for node in nodes)
    return Part(
        source, term, tuple(nodes), cells, solvable, _definitions(term, numbers, repeated), partial, listed, cost
    )


def _cells(node: Node, numbers: Mapping[Cell, int]) -> tuple[int, ...]:
    """The cells that a term mentions itself."""
    if isinstance(node.term, Opaque):
        return tuple(numbers[cell] for cell in node.term.cells)
    return (node.cell,) if node.cell >= 0 else ()


def _row(term: Term, numbers: Mapping[Cell, int]) -> list[Node]:
    """The terms of a term, operands before what is made of them."""
    row: list[Node] = []
    places: list[int] = []  # of terms whose owner is still to come
    todo: list[tuple[Term, bool]] = [(term, False)]
    while todo:
        current, opened = todo.pop()
        inside = operands(current)
        if inside and not opened:
            todo.append((current, True))
            todo.extend((operand, False) for operand in reversed(inside))
            continue
        args = tuple(places[len(places) - len(inside) :])
        del places[len(places) - len(inside) :]
        places.append(len(row))
        cell = numbers[current.cell] if isinstance(current, CellRef) else -1
        row.append(Node(current, args, cell, single(current.value) if isinstance(current, Const) else ANYTHING))
    return row


def _is_partial(term: Term) -> bool:
    return isinstance(term, Opaque) or (isinstance(term, Arithmetic) and term.operator in "/%")


def _is_coarse(term: Term) -> bool:
    match term:
        case Arithmetic(operator):
            return operator in "*/%"
        case Or() | Implies() | IfThenElse() | Opaque():
            return True
        case _:
            return False


def _definitions(term: Term, numbers: Mapping[Cell, int], repeated: bool) -> tuple[tuple[int, Term], ...]:
    """The cells that stand alone on one side of an equality, each with the other side."""
    if not isinstance(term, Compare) or term.operator != "==":
        return ()
    return tuple(
        (numbers[side.cell], other)
        for side, other in ((term.left, term.right), (term.right, term.left))
        if isinstance(side, CellRef) and not (repeated and side.cell in cells_of(other))
    )


def _solvable(term: Term, numbers: Mapping[Cell, int]) -> tuple[int, ...]:
    """The cells that an equality leaves one value for; none of them occurs twice in it."""
    if not isinstance(term, Compare) or term.operator != "==":
        return ()
    found: list[int] = []
    todo = [term.left, term.right]
    while todo:
        match todo.pop():
            case CellRef(cell):
                found.append(numbers[cell])
            case Negate(operand) | ToWhole(operand):
                todo.append(operand)
            case Arithmetic("+" | "-", left, right):
                todo += [left, right]
            case Arithmetic("*" | "/", left, right, Number.FLOAT) if not (cells_of(left) and cells_of(right)):
                todo += [left, right]
            case _:
                pass
    return tuple(sorted(found))
