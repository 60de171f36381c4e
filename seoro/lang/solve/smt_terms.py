"""Terms in the language of z3: ints as mathematical integers, floats as reals, all other values by number."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any, Final, assert_never, cast

import z3

from seoro.lang.integers import INT_LIMITS, UINT_LIMITS
from seoro.lang.solve.cells import Boolean, Cell, Choice, Free, Integer, Real, Value
from seoro.lang.solve.sets import Anything, Finite, Range, ValueSet
from seoro.lang.solve.terms import (
    And,
    Arithmetic,
    CellRef,
    Compare,
    Const,
    IfThenElse,
    Implies,
    InRange,
    InSet,
    Negate,
    Not,
    Number,
    Or,
    Relation,
    Term,
    ToReal,
    ToWhole,
    operands,
    subterms,
)

Expression = Any  # z3 has no types

_RELATIONS: Final[Mapping[Relation, Callable[[Expression, Expression], Expression]]] = {
    "==": lambda left, right: left == right,
    "!=": lambda left, right: left != right,
    "<": lambda left, right: left < right,
    "<=": lambda left, right: left <= right,
    ">": lambda left, right: left > right,
    ">=": lambda left, right: left >= right,
}


class Translation:
    """Terms and values to z3 and back.

    Args:
        known: The values of cells that have one.
    """

    def __init__(self, known: Mapping[Cell, Value]) -> None:
        self.context = z3.Context()
        self.conditions: list[Expression] = []  # that keep results in their 64 bits
        self._known = known
        self._variables: dict[Cell, Expression] = {}
        self._tokens: list[Value] = []

    def variable(self, cell: Cell) -> Expression:
        """The unknown that stands for a cell."""
        if cell not in self._variables:
            name = f"{len(self._variables)} {cell.name}"
            match cell.domain:
                case Boolean():
                    made = z3.Bool(name, self.context)
                case Real():
                    made = z3.Real(name, self.context)
                case Integer() | Free():
                    made = z3.Int(name, self.context)
                case Choice(values):
                    made = (z3.Real if _kind(values) is float else z3.Int)(name, self.context)
                case _:
                    assert_never(cell.domain)
            self._variables[cell] = made
        return self._variables[cell]

    def constant(self, value: Value) -> Expression:
        """A value; one that is neither truth nor number gets a number of its own."""
        if isinstance(value, bool):
            return z3.BoolVal(value, self.context)
        if type(value) is int:
            return z3.IntVal(value, self.context)
        if type(value) is float:
            return self._real(value)
        if value not in self._tokens:
            self._tokens.append(value)
        return z3.IntVal(self._tokens.index(value), self.context)

    def value(self, cell: Cell, found: Expression) -> Value:
        """The value of a cell, from what a model has for it."""
        if z3.is_bool(found):
            return bool(z3.is_true(found))
        if isinstance(cell.domain, Real) or (
            isinstance(cell.domain, Choice) and _kind(cell.domain.values) is float
        ):
            if z3.is_algebraic_value(found):
                found = found.approx(30)
            return float(Fraction(found.numerator_as_long(), found.denominator_as_long()))
        number = cast(int, found.as_long())
        if isinstance(cell.domain, Integer) or (
            isinstance(cell.domain, Choice) and _kind(cell.domain.values) is int
        ):
            return number
        return self._tokens[number] if number < len(self._tokens) else None

    def inside(self, cell: Cell, values: ValueSet) -> Expression:
        """That a cell is in a set."""
        variable = self.variable(cell)
        match values:
            case Finite(members):
                return z3.Or([variable == self.constant(member) for member in members])
            case Range(low, high):
                bounds = [variable >= self.constant(low)] if math.isfinite(low) else []
                bounds += [variable <= self.constant(high)] if math.isfinite(high) else []
                return z3.And(*bounds, self.constant(True))
            case Anything():
                return self.constant(True)
            case _:
                assert_never(values)

    def term(self, term: Term) -> Expression:
        """A term; opaque ones have no translation."""
        done: list[Expression] = []  # of terms whose owner is still to come
        for part in subterms(term):
            first = len(done) - len(operands(part))
            done[first:] = [self._made_of(part, done[first:])]
        return done[0]

    def _made_of(self, term: Term, parts: list[Expression]) -> Expression:
        """A term, given what it is made of."""
        match term, parts:
            case Const(value), []:
                return self.constant(value)
            case CellRef(cell), []:
                return self.constant(self._known[cell]) if cell in self._known else self.variable(cell)
            case Compare(relation), [left, right]:
                return _RELATIONS[relation](left, right)
            case Arithmetic(operation, number=number), [left, right]:
                return self._held(self._calculate(operation, left, right, number), number)
            case Negate(number=number), [operand]:
                return self._held(-operand, number)
            case ToReal(), [operand]:
                return z3.ToReal(operand)
            case ToWhole(number=number), [operand]:
                return self._held(operand, number)
            case InRange(), [item, low, high]:
                return z3.And(low <= item, item <= high)
            case InSet(values=members), [item]:
                return z3.Or(*(item == self.constant(member) for member in members), self.constant(False))
            case Not(), [operand]:
                return z3.Not(operand)
            case And(), _:
                return z3.And(*parts, self.constant(True))
            case Or(), _:
                return z3.Or(*parts, self.constant(False))
            case Implies(), [premise, conclusion]:
                return z3.Implies(premise, conclusion)
            case IfThenElse(), [condition, then, otherwise]:
                return z3.If(condition, then, otherwise)
            case _:
                raise AssertionError("constraints with opaque terms are not translated")

    def holds(self, term: Term) -> Expression:
        """That a constraint holds, which includes that what it always evaluates can be evaluated."""
        divisors = [self.term(divisor) != 0 for divisor in _divisors(term)]
        return z3.And(self.term(term), *divisors)

    def _real(self, value: float) -> Expression:
        exact = Fraction(value)
        return z3.RatVal(exact.numerator, exact.denominator, self.context)

    def _held(self, result: Expression, number: Number) -> Expression:
        """A result that its type can hold: values for which it would wrap are left to search."""
        if number is Number.FLOAT:
            return result
        low, high = INT_LIMITS if number is Number.INT else UINT_LIMITS
        self.conditions.append(z3.And(result >= low, result <= high))
        return result

    def _calculate(self, operation: str, left: Expression, right: Expression, number: Number) -> Expression:
        match operation:
            case "+":
                return left + right
            case "-":
                return left - right
            case "*":
                return left * right
            case "/" if number is Number.FLOAT:
                return left / right
            case "/":
                return _truncated(left, right)
            case _ if number is Number.FLOAT:
                quotient = left / right
                whole = z3.If(quotient >= 0, z3.ToInt(quotient), -z3.ToInt(-quotient))
                return left - right * z3.ToReal(whole)
            case _:
                return left - right * _truncated(left, right)


def _divisors(term: Term) -> Iterator[Term]:
    """What integers are divided by whenever a term is evaluated: not what `and` and the like may leave out."""
    todo = [term]
    while todo:
        current = todo.pop()
        if isinstance(current, Arithmetic) and current.operator in "/%" and current.number is not Number.FLOAT:
            yield current.right
        inside = operands(current)
        todo.extend(inside[:1] if isinstance(current, And | Or | Implies | IfThenElse | InRange) else inside)


def _truncated(left: Expression, right: Expression) -> Expression:
    """A quotient of integers, rounded toward zero; that of z3 leaves a remainder that is not negative."""
    return z3.If(left >= 0, left / right, -(-left / right))


def _kind(values: tuple[Value, ...]) -> type | None:
    """Whether all values are ints, or all floats; None if they are anything else."""
    kinds = {type(value) for value in values}
    return kinds.pop() if kinds in ({int}, {float}) else None
