"""Parts of constraints for propagation: split at `and`, with terms in a row, and numbered cells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from seoro.lang import frozen
from seoro.lang.arithmetic import Number
from seoro.lang.solve import terms
from seoro.lang.solve.problem import Constraint
from seoro.lang.solve.sets import ANYTHING, ValueSet, single
from seoro.lang.solve.terms import Cell


class Node(frozen.Frozen):
    """One term of a part.

    Args:
        term: The term.
        args: Positions of its operands in the row.
        cell: Number of its cell; -1 for other terms.
        constant: Its value, if it is a constant.
    """

    term: terms.Term
    args: tuple[int, ...]
    cell: int
    constant: ValueSet


class Part(frozen.Frozen):
    """A constraint, or one member of its conjunction.

    Args:
        source: Number of the constraint.
        term: Its condition.
        nodes: Its terms, operands first; the last is the whole.
        cells: Numbers of its cells.
        solvable: Cells that the others determine, because the part is an equality with an inverse.
        definitions: Cells that are equal to a term without them, with the term.
        partial: Whether it may have no value.
        conditional: Whether it may hold without a value of each of its terms.
        listed: Whether contraction of the last open cell may leave invalid values.
        cost: Cost of its evaluation [terms].
    """

    source: int
    term: terms.Term
    nodes: tuple[Node, ...]
    cells: tuple[int, ...]
    solvable: tuple[int, ...]
    definitions: tuple[tuple[int, terms.Term], ...]
    partial: bool
    conditional: bool
    listed: bool
    cost: int


_CONDITIONS: Final = terms.Or | terms.Implies | terms.IfThenElse | terms.Not


def parts_of(constraints: tuple[Constraint, ...], numbers: Mapping[Cell, int]) -> tuple[Part, ...]:
    """Return the parts of all constraints, in order."""
    return tuple(
        _part(source, term, numbers)
        for source, constraint in enumerate(constraints)
        for term in conjuncts(constraint.term)
    )


def conjuncts(term: terms.Term) -> Iterator[terms.Term]:
    """Yield the members of a conjunction, including nested ones, or the term itself."""
    todo = [term]
    while todo:
        current = todo.pop()
        if isinstance(current, terms.And):
            todo.extend(reversed(current.operands))
        else:
            yield current


def _part(source: int, term: terms.Term, numbers: Mapping[Cell, int]) -> Part:
    nodes = _row(term, numbers)
    mentioned = [cell for node in nodes for cell in _cells(node, numbers)]
    cells = tuple(dict.fromkeys(mentioned))
    repeated = len(mentioned) > len(cells)
    partial = any(_is_partial(node.term) for node in nodes)
    conditional = any(isinstance(node.term, _CONDITIONS) for node in nodes)
    listed = repeated or any(_is_coarse(node.term) for node in nodes)
    solvable = () if repeated else _solvable(term, numbers)
    cost = sum(node.term.cost if isinstance(node.term, terms.Opaque) else 1 for node in nodes)
    definitions = _definitions(term, numbers, repeated)
    return Part(source, term, tuple(nodes), cells, solvable, definitions, partial, conditional, listed, cost)


def _cells(node: Node, numbers: Mapping[Cell, int]) -> tuple[int, ...]:
    """Return the cells that a term contains directly."""
    if isinstance(node.term, terms.Opaque):
        return tuple(numbers[cell] for cell in node.term.cells)
    return (node.cell,) if node.cell >= 0 else ()


def _row(term: terms.Term, numbers: Mapping[Cell, int]) -> list[Node]:
    """Return a term and its subterms, operands first."""
    row: list[Node] = []
    places: list[int] = []  # of terms whose owner follows
    for current in terms.subterms(term):
        first = len(places) - len(terms.operands(current))
        args = tuple(places[first:])
        places[first:] = [len(row)]
        cell = numbers[current.cell] if isinstance(current, terms.CellRef) else -1
        row.append(
            Node(current, args, cell, single(current.value) if isinstance(current, terms.Const) else ANYTHING)
        )
    return row


def _is_partial(term: terms.Term) -> bool:
    return isinstance(term, terms.Opaque) or (isinstance(term, terms.Arithmetic) and term.operator in "/%")


def _is_coarse(term: terms.Term) -> bool:
    match term:
        case terms.Arithmetic(operator):
            return operator in "*/%"
        case terms.Or() | terms.Implies() | terms.IfThenElse() | terms.Opaque():
            return True
        case _:
            return False


def _definitions(
    term: terms.Term, numbers: Mapping[Cell, int], repeated: bool
) -> tuple[tuple[int, terms.Term], ...]:
    """Return the cells that are one side of an equality, each with the other side."""
    if not isinstance(term, terms.Compare) or term.operator != "==":
        return ()
    return tuple(
        (numbers[side.cell], other)
        for side, other in ((term.left, term.right), (term.right, term.left))
        if isinstance(side, terms.CellRef) and not (repeated and side.cell in terms.cells_of(other))
    )


def _solvable(term: terms.Term, numbers: Mapping[Cell, int]) -> tuple[int, ...]:
    """Return the cells that an equality determines, given the others; each occurs once in it."""
    if not isinstance(term, terms.Compare) or term.operator != "==":
        return ()
    found: list[int] = []
    todo = [term.left, term.right]
    while todo:
        match todo.pop():
            case terms.CellRef(cell):
                found.append(numbers[cell])
            case terms.Negate(operand) | terms.ToWhole(operand):
                todo.append(operand)
            case terms.Arithmetic("+" | "-", left, right):
                todo += [left, right]
            case terms.Arithmetic("*" | "/", left, right, Number.FLOAT) if not (
                terms.cells_of(left) and terms.cells_of(right)
            ):
                todo += [left, right]
            case _:
                pass
    return tuple(sorted(found))
