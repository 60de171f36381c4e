"""`.is()` and `.as()` (7.4.2.5, 7.4.2.6): results that are static or depend on the value."""

from __future__ import annotations

from seoro.lang import ast, plan
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.plan_types import plan_type
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostics import methods as messages
from seoro.lang.symbols import Enumeration, ListOf, RangeOf, Structured, Type, TypeSymbol, lineage
from seoro.lang.types import BOOL, is_integer, is_known, is_number, is_plain_number


class Casts:
    """Elaborates type tests and conversions.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions

    def test(self, node: ast.TypeTestExp, scope: Scope) -> Typed:
        """`a.is(T)`."""
        target = self._expressions.type_of(node.type, scope.space)
        operand = self._expressions.value(node.base, scope, target if is_number(target) else None)
        if not is_known(target) or not is_known(operand.type):
            return Typed(plan.Literal(False, node.span), BOOL)
        if not _depends_on_value(operand.type, target):
            return Typed(plan.Literal(operand.type == target, node.span), BOOL)
        wanted = plan_type(target, self._expressions.program)
        return Typed(plan.TypeTest(operand.expression, wanted, node.span), BOOL)

    def cast(self, node: ast.CastExp, scope: Scope) -> Typed:
        """`a.as(T)`."""
        expressions = self._expressions
        target = expressions.type_of(node.type, scope.space)
        operand = expressions.value(node.base, scope)
        if not is_known(target) or not is_known(operand.type):
            return nothing(node.span)
        if operand.type == target:
            return Typed(operand.expression, target)
        if not _may_become(operand.type, target):
            describe = expressions.converter.describe
            expressions.bag.add(messages.impossible_cast, node.span, describe(operand.type), describe(target))
            return nothing(node.span)
        return Typed(plan.Cast(operand.expression, plan_type(target, expressions.program), node.span), target)


def _depends_on_value(source: Type, target: Type) -> bool:
    """Return whether a value of a type decides if it is of another type."""
    match source, target:
        case Structured(a), Structured(b):
            return _may_share(a, b)
        case ListOf(a), ListOf(b):
            return _depends_on_value(a, b)
        case _:
            return False


def _may_become(source: Type, target: Type) -> bool:
    """Return whether some value of a type can be converted to another one."""
    match source, target:
        case Structured(a), Structured(b):
            return _may_share(a, b)
        case (Enumeration(), _):
            return is_integer(target)
        case (_, Enumeration()):
            return is_integer(source)
        case (ListOf(a), ListOf(b)) | (RangeOf(a), RangeOf(b)):
            return a == b or _may_become(a, b)
        case (_, RangeOf(element)):
            return source == element or _may_become(source, element)
        case _:
            return is_plain_number(source) and is_plain_number(target)


def _may_share(left: TypeSymbol, right: TypeSymbol) -> bool:
    """Return whether a value can be of both types: by inheritance, or by conditions on one base."""
    first, second = _unconditional(left), _unconditional(right)
    return first in lineage(second) or second in lineage(first)


def _unconditional(symbol: TypeSymbol) -> TypeSymbol:
    """Return the nearest unconditional base of a type."""
    return next(type_ for type_ in lineage(symbol) if type_.condition is None or type_.base is None)
