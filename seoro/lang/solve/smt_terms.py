"""Terms in z3: ints as mathematical integers, floats as reals, other values by number."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, assert_never, cast

import z3

from seoro.lang.arithmetic import Number
from seoro.lang.solve import terms
from seoro.lang.solve.evaluation import RELATIONS
from seoro.lang.solve.intervals import LIMITS
from seoro.lang.solve.sets import Anything, Finite, Range, ValueSet
from seoro.lang.solve.terms import Boolean, Cell, Choice, Free, Integer, Real, Value

Expression = Any  # z3 has no types


class Translation:
    """Conversion of terms and values to z3 and back.

    Args:
        known: Values of the known cells.
    """

    def __init__(self, known: Mapping[Cell, Value]) -> None:
        self.context = z3.Context()
        self.conditions: list[Expression] = []  # limits of results to 64 bits
        self._known = known
        self._variables: dict[Cell, Expression] = {}
        self._tokens: list[Value] = []

    def variable(self, cell: Cell) -> Expression:
        """Return the variable of a cell."""
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
        """Convert a value; tokens get numbers."""
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
        """Convert the result of a model to the value of a cell."""
        if z3.is_bool(found):
            return bool(z3.is_true(found))
        if z3.is_real(found):
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
        """Return the condition that a cell is in a set."""
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

    def term(self, term: terms.Term) -> Expression:
        """Convert a term; opaque ones are unsupported."""
        done: list[Expression] = []  # of terms whose owner follows
        for part in terms.subterms(term):
            first = len(done) - len(terms.operands(part))
            done[first:] = [self._made_of(part, done[first:])]
        return done[0]

    def _made_of(self, term: terms.Term, parts: list[Expression]) -> Expression:
        """Convert a term with converted operands."""
        match term, parts:
            case terms.Const(value), []:
                return self.constant(value)
            case terms.CellRef(cell), []:
                return self.constant(self._known[cell]) if cell in self._known else self.variable(cell)
            case terms.Compare(relation), [left, right]:
                return RELATIONS[relation](left, right)
            case terms.Arithmetic(operation, number=number), [left, right]:
                return self._held(self._calculate(operation, left, right, number), number)
            case terms.Negate(number=number), [operand]:
                return self._held(-operand, number)
            case terms.ToReal(), [operand]:
                return z3.ToReal(operand)
            case terms.ToWhole(number=number), [operand]:
                return self._held(operand, number)
            case terms.InRange(), [item, low, high]:
                return z3.And(low <= item, item <= high)
            case terms.InSet(values=members), [item]:
                return z3.Or(*(item == self.constant(member) for member in members), self.constant(False))
            case terms.Not(), [operand]:
                return z3.Not(operand)
            case terms.And(), _:
                return z3.And(*parts, self.constant(True))
            case terms.Or(), _:
                return z3.Or(*parts, self.constant(False))
            case terms.Implies(), [premise, conclusion]:
                return z3.Implies(premise, conclusion)
            case terms.IfThenElse(), [condition, then, otherwise]:
                return z3.If(condition, then, otherwise)
            case _:
                raise AssertionError("constraints with opaque terms are not translated")

    def holds(self, term: terms.Term) -> Expression:
        """Return the condition that a constraint holds, and that no evaluated divisor is zero."""
        divisors = [self.term(divisor) != 0 for divisor in _divisors(term)]
        return z3.And(self.term(term), *divisors)

    def _real(self, value: float) -> Expression:
        exact = Fraction(value)
        return z3.RatVal(exact.numerator, exact.denominator, self.context)

    def _held(self, result: Expression, number: Number) -> Expression:
        """Limit a result to its type; search handles values that wrap."""
        if number is Number.FLOAT:
            return result
        low, high = LIMITS[number]
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


def _divisors(term: terms.Term) -> Iterator[terms.Term]:
    """Yield the integer divisors that each evaluation of a term uses, unlike skipped operands of `and`."""
    todo = [term]
    while todo:
        current = todo.pop()
        if (
            isinstance(current, terms.Arithmetic)
            and current.operator in "/%"
            and current.number is not Number.FLOAT
        ):
            yield current.right
        inside = terms.operands(current)
        todo.extend(
            inside[:1]
            if isinstance(current, terms.And | terms.Or | terms.Implies | terms.IfThenElse | terms.InRange)
            else inside
        )


def _truncated(left: Expression, right: Expression) -> Expression:
    """Return a quotient of integers, rounded toward zero, unlike the division of z3."""
    return z3.If(left >= 0, left / right, -(-left / right))


def _kind(values: tuple[Value, ...]) -> type | None:
    """Return the type of the values if all are ints, or all are floats, else None."""
    kinds = {type(value) for value in values}
    return kinds.pop() if kinds in ({int}, {float}) else None
