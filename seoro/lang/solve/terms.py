"""Terms: expressions of cells in constraints, as a closed union of frozen nodes; cells are the unknowns.

The operands of a comparison or an operation have one type. Only `ToReal` converts integers to reals, and only
`ToWhole` converts them to the other integer type. Integers have 64 bits and wrap, `/` truncates toward zero, and
`%` has the sign of the dividend. Reals follow IEEE 754 (7.4.2.3).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from typing import TYPE_CHECKING, Final, Literal, TypeAlias, assert_never

from seoro.lang import frozen
from seoro.lang.arithmetic import INT_LIMITS, Number

if TYPE_CHECKING:
    from seoro.lang.source import Span


# A bool, an int, a float, a string, or a token. Tokens are other objects that can only be compared for equality,
# such as members of enumerations or references to actors.
Value: TypeAlias = Hashable


class Boolean(frozen.Value):
    """True or false."""


class Choice(frozen.Value):
    """One of a few different values, such as the members of an enumeration; at least one."""

    values: tuple[Value, ...]


class Integer(frozen.Value):
    """An integer, bounds included. The limits of its type do not count as bounds."""

    low: int = INT_LIMITS[0]
    high: int = INT_LIMITS[1]


class Real(frozen.Value):
    """A float, or a physical value in the SI unit of its dimension; bounds included."""

    low: float = float("-inf")
    high: float = float("inf")


class Free(frozen.Value):
    """A value that only an equality can determine: a string, a reference."""


Domain: TypeAlias = Boolean | Choice | Integer | Real | Free


class Cell(frozen.Frozen):
    """One unknown; a cell equals only itself.

    Args:
        name: Its path for people, such as `robot.goal.x`; unique in a problem, and the name of its random stream.
        span: Its declaration.
        domain: Values of its type.
    """

    name: str
    span: Span
    domain: Domain


Operation: TypeAlias = Literal["+", "-", "*", "/", "%"]
Relation: TypeAlias = Literal["==", "!=", "<", "<=", ">", ">="]


class Unevaluable(Exception):
    """A term has no value, by a division by zero or an opaque term; its constraint does not hold."""


class Const(frozen.Value):
    """A constant; a float for reals."""

    value: Value


class CellRef(frozen.Value):
    """The value of a cell."""

    cell: Cell


class Negate(frozen.Value):
    """Unary minus."""

    operand: Term
    number: Number


class Arithmetic(frozen.Value):
    """`+`, `-`, `*`, `/` or `%` of two numbers."""

    operator: Operation
    left: Term
    right: Term
    number: Number


class ToReal(frozen.Value):
    """Conversion of an integer to a real."""

    operand: Term


class ToWhole(frozen.Value):
    """Conversion of an integer to the other integer type, which may wrap.

    Args:
        operand: The number.
        number: The target type, `INT` or `UINT`.
    """

    operand: Term
    number: Number


class Compare(frozen.Value):
    """A comparison; `==` and `!=` of any two values, the others of numbers."""

    operator: Relation
    left: Term
    right: Term


class InRange(frozen.Value):
    """Membership of a number in a range, bounds included; the range is empty if `low` is above `high`."""

    item: Term
    low: Term
    high: Term


class InSet(frozen.Value):
    """Membership of a value in a list of values."""

    item: Term
    values: tuple[Value, ...]


class Not(frozen.Value):
    """Logical negation."""

    operand: Term


class And(frozen.Value):
    """Conjunction; evaluated from the left as far as needed."""

    operands: tuple[Term, ...]


class Or(frozen.Value):
    """Disjunction; evaluated from the left as far as needed."""

    operands: tuple[Term, ...]


class Implies(frozen.Value):
    """Implication."""

    premise: Term
    conclusion: Term


class IfThenElse(frozen.Value):
    """Choice of one of two values by a condition."""

    condition: Term
    then: Term
    otherwise: Term


def other_whole(number: Number) -> Number:
    """Return the other integer type."""
    return Number.UINT if number is Number.INT else Number.INT


OPAQUE_COST: Final = 30


class Opaque(frozen.Value):
    """A term of any other kind, which is evaluated only with known cells.

    Args:
        cells: Cells that it depends on.
        evaluate: Pure function that returns its value; may raise `Unevaluable`.
        label: Its name for people.
        cost: Cost of its evaluation [terms of other kinds].
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
    """Return the operands of a term, from the left."""
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
    """Return whether two terms are equal, without recursion, since terms may be long."""
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
    """Return the fields of a term except its operands."""
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
    """Yield a term and its subterms, operands first."""
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
    """Return the cells in a term, each once, from the left."""
    found: dict[Cell, None] = {}
    for part in subterms(term):
        if isinstance(part, CellRef):
            found[part.cell] = None
        elif isinstance(part, Opaque):
            found.update(dict.fromkeys(part.cells))
    return tuple(found)
