"""Terms: what constraints say about cells, as a closed union of frozen nodes.

The operands of a comparison or an operation have one type; whole numbers become reals by `ToReal` only, and whole
numbers of the other kind by `ToWhole`. Integers are 64 bit and wrap, `/` truncates toward zero and `%` has the
sign of the dividend; reals follow IEEE 754 (7.4.2.3).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from typing import Final, Literal, TypeAlias, assert_never

from seoro.lang import frozen
from seoro.lang.solve.cells import Cell, Value


class Number(Enum):
    """What an operation computes with."""

    INT = "int"
    UINT = "uint"
    FLOAT = "float"


Operation: TypeAlias = Literal["+", "-", "*", "/", "%"]
Relation: TypeAlias = Literal["==", "!=", "<", "<=", ">", ">="]


class Unevaluable(Exception):
    """A term has no value: a division by zero, or what an opaque term says. Its constraint does not hold."""


class Const(frozen.Value):
    """A value; that of a real is a float."""

    value: Value


class CellRef(frozen.Value):
    """The value of a cell."""

    cell: Cell


class Negate(frozen.Value):
    """Minus something."""

    operand: Term
    number: Number


class Arithmetic(frozen.Value):
    """`+`, `-`, `*`, `/` or `%` of two numbers."""

    operator: Operation
    left: Term
    right: Term
    number: Number


class ToReal(frozen.Value):
    """A whole number as a real."""

    operand: Term


class ToWhole(frozen.Value):
    """A whole number as one of the other kind, which may wrap.

    Args:
        operand: The number.
        number: The kind that it becomes, `INT` or `UINT`.
    """

    operand: Term
    number: Number


class Compare(frozen.Value):
    """A comparison; `==` and `!=` of any two values, the others of numbers."""

    operator: Relation
    left: Term
    right: Term


class InRange(frozen.Value):
    """Whether a number lies in a range, bounds included; nothing lies in one whose low is above its high."""

    item: Term
    low: Term
    high: Term


class InSet(frozen.Value):
    """Whether something is one of some values."""

    item: Term
    values: tuple[Value, ...]


class Not(frozen.Value):
    """Logical negation."""

    operand: Term


class And(frozen.Value):
    """All hold; evaluated from the left as far as needed."""

    operands: tuple[Term, ...]


class Or(frozen.Value):
    """At least one holds; evaluated from the left as far as needed."""

    operands: tuple[Term, ...]


class Implies(frozen.Value):
    """The second holds if the first does."""

    premise: Term
    conclusion: Term


class IfThenElse(frozen.Value):
    """One of two values, as the condition says."""

    condition: Term
    then: Term
    otherwise: Term


def other_whole(number: Number) -> Number:
    """The kind of whole numbers that is not `number`."""
    return Number.UINT if number is Number.INT else Number.INT


OPAQUE_COST: Final = 30


class Opaque(frozen.Value):
    """Anything else: looked at only when all its cells have values.

    Args:
        cells: What it depends on.
        evaluate: Its value; pure. May raise `Unevaluable`.
        label: What people call it.
        cost: How long it takes to evaluate it, in terms of the other kinds.
    """

    cells: tuple[Cell, ...]
    evaluate: Callable[[Mapping[Cell, Value]], Value]
    label: str
    cost: int = OPAQUE_COST


Term: TypeAlias = (
    Const
    | CellRef
    | Negate
    | Arithmetic
    | ToReal
    | ToWhole
    | Compare
    | InRange
    | InSet
    | Not
    | And
    | Or
    | Implies
    | IfThenElse
    | Opaque
)


def operands(term: Term) -> tuple[Term, ...]:
    """What a term is made of, from the left."""
    match term:
        case Const() | CellRef() | Opaque():
            return ()
        case Negate(operand) | ToReal(operand) | ToWhole(operand) | Not(operand):
            return (operand,)
        case Arithmetic(_, left, right) | Compare(_, left, right) | Implies(left, right):
            return (left, right)
        case InRange(item, low, high):
            return (item, low, high)
        case InSet(item):
            return (item,)
        case And(parts) | Or(parts):
            return parts
        case IfThenElse(condition, then, otherwise):
            return (condition, then, otherwise)
        case _:
            assert_never(term)


def alike(one: Term, other: Term) -> bool:
    """Whether two terms are equal; they may be long, so it is no recursion."""
    pairs = [(one, other)]
    while pairs:
        first, second = pairs.pop()
        inner, outer = operands(first), operands(second)
        if type(first) is not type(second) or len(inner) != len(outer):
            return False
        if (first != second) if not inner else (_own(first) != _own(second)):
            return False
        pairs += zip(inner, outer, strict=True)
    return True


def _own(term: Term) -> object:
    """What a term says beside its operands."""
    match term:
        case Arithmetic(operator, number=number):
            return operator, number
        case Compare(operator):
            return operator
        case Negate(_, number) | ToWhole(_, number):
            return number
        case InSet(_, values):
            return values
        case _:
            return None


def subterms(term: Term) -> Iterator[Term]:
    """A term and all that it is made of, operands before what is made of them."""
    todo: list[tuple[Term, bool]] = [(term, False)]
    while todo:
        current, opened = todo.pop()
        inside = () if opened else operands(current)
        if not inside:
            yield current
            continue
        todo.append((current, True))
        todo.extend((operand, False) for operand in reversed(inside))


def cells_of(term: Term) -> tuple[Cell, ...]:
    """The cells that a term mentions, each once, from the left."""
    found: dict[Cell, None] = {}
    for part in subterms(term):
        if isinstance(part, CellRef):
            found[part.cell] = None
        elif isinstance(part, Opaque):
            found.update(dict.fromkeys(part.cells))
    return tuple(found)
