"""Operators: types of their operands and results (7.4.2.2 to 7.4.2.4, 7.3.4)."""

from __future__ import annotations

from seoro.lang import ast, plan
from seoro.lang.arithmetic import Number
from seoro.lang.check.convert import NUMBERS, Converter, Typed, adapted, as_number, common_type, nothing
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import types as messages
from seoro.lang.program import Program
from seoro.lang.source import Span
from seoro.lang.symbols import ListOf, Quantity, RangeOf, Type
from seoro.lang.types import BOOL, INT, STRING, UINT, dimension_of, is_integer, is_known, is_number, quantity
from seoro.lang.units import product, quotient


class Operators:
    """Elaborates operators on typed operands.

    Args:
        program: The program.
        converter: Converter of operands.
        bag: Bag for messages.
        strict: Whether to report extensions to the standard.
    """

    def __init__(self, program: Program, converter: Converter, bag: Bag, strict: bool) -> None:
        self._program = program
        self._converter = converter
        self._bag = bag
        self._strict = strict

    # ------------------------------------------------------------ arithmetic (7.4.2.3)

    def negate(self, operand: Typed, span: Span) -> Typed:
        """Elaborate `-a`, an `int` if `a` is a `uint`."""
        if not is_known(operand.type):
            return nothing(span)
        if not is_number(operand.type):
            found = self._converter.describe(operand.type)
            self._bag.add(messages.not_number, operand.expression.span, "-", found)
            return nothing(span)
        result = INT if operand.type == UINT else operand.type
        return Typed(plan.Negate(operand.expression, NUMBERS.get(result, Number.FLOAT), span), result)

    def arithmetic(self, node: ast.Arithmetic, left: Typed, right: Typed, wants_int: bool) -> Typed:
        """Elaborate `a + b` and the like.

        Args:
            node: The operator; the span of its `left` ends with the left operand.
            left: The left operand.
            right: The right operand.
            wants_int: Whether a result from integer literals alone is an `int`.
        """
        span = node.span
        if not is_known(left.type) or not is_known(right.type):
            return nothing(span)
        if node.operator == "+" and left.type == STRING and right.type == STRING:
            return Typed(plan.Concatenate(left.expression, right.expression, span), STRING)
        if not is_number(left.type) or not is_number(right.type):
            self._unlike(node, left, right)
            return nothing(span)
        if not (isinstance(left.type, Quantity) or isinstance(right.type, Quantity)):
            return self._plain(node, left, right, wants_int)
        if node.operator in {"*", "/"}:
            join = product if node.operator == "*" else quotient
            result = quantity(join(dimension_of(left.type), dimension_of(right.type)))
        elif left.type == right.type:
            result = left.type
        else:
            self._unlike(node, left, right)
            return nothing(span)
        a, b = _as_float(left), _as_float(right)
        return Typed(plan.Arithmetic(node.operator, a, b, Number.FLOAT, span), result)

    def _plain(self, node: ast.Arithmetic, left: Typed, right: Typed, wants_int: bool) -> Typed:
        result = common_type(left.type, right.type)
        assert result is not None
        if result == UINT and wants_int:
            result = INT
        a, b = self._converter.convert(left, result), self._converter.convert(right, result)
        return Typed(plan.Arithmetic(node.operator, a, b, NUMBERS.get(result, Number.FLOAT), node.span), result)

    def _unlike(self, node: ast.Arithmetic, left: Typed, right: Typed) -> None:
        describe = self._converter.describe
        self._bag.add(
            messages.incompatible_operands,
            node.left.span,
            node.right.span,
            node.operator,
            describe(left.type),
            describe(right.type),
            self._relation_between(left.type, right.type) if node.operator in "+-" else "",
        )

    def _relation_between(self, left: Type, right: Type) -> str:
        """Return help like `a length is a speed times a time`, if a third type relates both."""
        if not isinstance(left, Quantity) or not isinstance(right, Quantity):
            return ""
        named = self._program.quantities
        for whole, part in ((left, right), (right, left)):
            third = named.get(quotient(whole.dimension, part.dimension))
            if third is not None and whole.dimension in named and part.dimension in named:
                symbols = [named[whole.dimension], named[part.dimension], third]
                return "{} is {} times {}".format(*(_article(name) for name in symbols))
        return ""

    # ------------------------------------------------------------ relations (7.4.2.4)

    def relation(self, node: ast.Relation, left: Typed, right: Typed) -> Typed:
        """Elaborate `a < b` and the like."""
        span = node.span
        if not is_known(left.type) or not is_known(right.type):
            return Typed(plan.Literal(False, span), BOOL)
        if node.operator == "in":
            return self._membership(node, left, right)
        left, right = self._with_range(node, left, right)
        shared = common_type(left.type, right.type)
        if shared is None:
            self._uncomparable(node, left, right)
        elif node.operator not in {"==", "!="} and not is_number(shared):
            self._bag.add(messages.unordered, span, node.operator, self._converter.describe(shared))
        else:
            return Typed(plan.Compare(node.operator, *_alike(node.operator, left, right, shared), span), BOOL)
        return Typed(plan.Literal(False, span), BOOL)

    def _with_range(self, node: ast.Relation, left: Typed, right: Typed) -> tuple[Typed, Typed]:
        """Return the operands of a comparison, after replacing those of a range and a number.

        For `==` and `!=`, the number becomes a range from and to itself (7.4.2.8.2). The standard does not define
        an order of both; it holds if it holds for the whole range, so one bound replaces the range.
        """
        if isinstance(left.type, RangeOf) == isinstance(right.type, RangeOf):
            return left, right
        number = right if isinstance(left.type, RangeOf) else left
        if not is_number(number.type):
            return left, right
        if node.operator in {"==", "!="}:
            return _as_range(left), _as_range(right)
        if self._strict:
            self._bag.add(messages.order_of_range, node.span, node.operator)
        of_left, of_right = plan.Side.UPPER, plan.Side.LOWER
        if node.operator in {">", ">="}:
            of_left, of_right = of_right, of_left
        return _bound(left, of_left), _bound(right, of_right)

    def _membership(self, node: ast.Relation, left: Typed, right: Typed) -> Typed:
        if not isinstance(right.type, ListOf | RangeOf):
            self._bag.add(messages.not_a_container, node.right.span, self._converter.describe(right.type))
            return Typed(plan.Literal(False, node.span), BOOL)
        item, kind = left.type, type(right.type)
        is_part = isinstance(item, kind)
        shared = common_type(item.element if isinstance(item, kind) else item, right.type.element)
        if shared is None:
            self._uncomparable(node, left, right)
            return Typed(plan.Literal(False, node.span), BOOL)
        a, b = adapted(left, kind(shared) if is_part else shared), adapted(right, kind(shared))
        return Typed(plan.Contains(a, b, node.span), BOOL)

    def _uncomparable(self, node: ast.Relation, left: Typed, right: Typed) -> None:
        describe = self._converter.describe
        shown = node.operator, describe(left.type), describe(right.type)
        self._bag.add(messages.incomparable_operands, node.left.span, node.right.span, *shown)

    # ------------------------------------------------------------ logic (7.4.2.2)

    def truth(self, value: Typed, operator: str, span: Span) -> plan.Expression:
        """Convert an operand to bool."""
        if is_known(value.type) and value.type != BOOL:
            self._bag.add(messages.not_bool, span, operator, self._converter.describe(value.type))
        return value.expression


def _as_float(side: Typed) -> plan.Expression:
    """Convert an integer operand to float."""
    return as_number(side.expression, Number.FLOAT) if is_integer(side.type) else side.expression


def _alike(operator: str, left: Typed, right: Typed, shared: Type) -> tuple[plan.Expression, plan.Expression]:
    """Convert the operands of a comparison to one type (7.4.2.4.1).

    An `int` and a `uint` compare equal in either type, since their values map one to one. The right operand is
    converted, so that the left one can stay the parameter of a constraint.
    """
    if operator in {"==", "!="} and not isinstance(left.expression, plan.Literal):
        whole = adapted(right, left.type)
        if whole is not right.expression and shared != left.type:
            return left.expression, whole
    return adapted(left, shared), adapted(right, shared)


def _as_range(side: Typed) -> Typed:
    """Convert a number to the range from and to itself."""
    if isinstance(side.type, RangeOf):
        return side
    number = side.expression
    return Typed(plan.RangeOf(number, number, number.span), RangeOf(side.type))


def _bound(side: Typed, which: plan.Side) -> Typed:
    """Return a bound of a range, or a number unchanged."""
    if not isinstance(side.type, RangeOf):
        return side
    return Typed(plan.Bound(which, side.expression, side.expression.span), side.type.element)


def _article(name: str) -> str:
    return f"a{'n' if name[0] in 'aeiou' else ''} `{name}`"
