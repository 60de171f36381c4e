"""Lists, ranges, `? :`, `.is()` and `.as()`: expressions for values of all types (7.4.2.5 to 7.4.2.9)."""

from __future__ import annotations

from seoro.lang import ast, plan
from seoro.lang.check.convert import Typed, common_type, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.plan_types import plan_type
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostics import methods, syntax, types
from seoro.lang.source import Span
from seoro.lang.symbols import Enumeration, ListOf, Quantity, RangeOf, Structured, Type, TypeSymbol, lineage
from seoro.lang.types import BOOL, UNKNOWN, is_integer, is_known, is_number, is_plain_number

MAX_CHAIN = 20_000  # of operands in a row


class Aggregates:
    """Elaborates aggregates, type tests and conversions.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions

    def ternary(self, node: ast.TernaryOpExp, scope: Scope, expected: Type | None) -> Typed:
        """Elaborate `c ? a : b`; long tables of conditions need no recursion."""
        expressions, rows = self._expressions, [node]
        while isinstance(last := rows[-1].otherwise, ast.TernaryOpExp):
            rows.append(last)
        if len(rows) > MAX_CHAIN:
            expressions.bag.add(syntax.too_deep, node.span, MAX_CHAIN)
            return nothing(node.span)
        parts: list[tuple[Span, plan.Expression, Typed]] = []
        for row in rows:
            found = expressions.value(row.condition, scope, BOOL)
            condition = expressions.operators.truth(found, "?", row.condition.span)
            parts.append((row.span, condition, expressions.value(row.then, scope, expected)))
        result = expressions.value(last, scope, expected)
        for span, condition, then in reversed(parts):
            result = self._conditional(span, condition, then, result)
        return result

    def _conditional(self, span: Span, condition: plan.Expression, then: Typed, otherwise: Typed) -> Typed:
        convert = self._expressions.converter.convert
        shared = common_type(then.type, otherwise.type)
        if shared is None:
            self._no_common("the results of `? :`", then, otherwise)
            return nothing(span)
        result = plan.Conditional(condition, convert(then, shared), convert(otherwise, shared), span)
        return Typed(result, shared if is_known(shared) else UNKNOWN)

    def list_of(self, node: ast.ListConstructor, scope: Scope, expected: Type | None) -> Typed:
        """Elaborate `[a, b]`; members that are list literals are flattened."""
        hint = expected.element if isinstance(expected, ListOf) else None
        items: list[Typed] = []
        for item in node.items:
            found = self._expressions.value(item, scope, hint)
            if isinstance(found.type, ListOf) and isinstance(found.expression, plan.ListOf):
                items += [Typed(inner, found.type.element) for inner in found.expression.items]
            else:
                items.append(found)
        if any(not is_known(item.type) for item in items):
            return nothing(node.span)
        shared = hint if _are_bare_numbers(items, hint) else self._common(items)
        if shared is None:
            return nothing(node.span)
        return Typed(self._joined(items, shared, node.span), ListOf(shared))

    def _joined(self, items: list[Typed], shared: Type, span: Span) -> plan.Expression:
        """Build a list of values; lists among them are joined."""
        convert = self._expressions.converter.convert
        lists: list[plan.Expression] = []
        values: list[plan.Expression] = []
        for item in items:
            if isinstance(item.type, ListOf):
                lists += [plan.ListOf(tuple(values), span)] if values else []
                lists.append(convert(item, ListOf(shared)))
                values = []
            else:
                values.append(convert(item, shared))
        if not lists:
            return plan.ListOf(tuple(values), span)
        return plan.Join((*lists, *([plan.ListOf(tuple(values), span)] if values else [])), span)

    def range_of(self, node: ast.RangeConstructor, scope: Scope, expected: Type | None) -> Typed:
        """`[a..b]` or `range(a, b)`."""
        expressions, convert = self._expressions, self._expressions.converter.convert
        hint = expected.element if isinstance(expected, RangeOf) else expected
        low, high = expressions.value(node.low, scope, hint), expressions.value(node.high, scope, hint)
        if not is_known(low.type) or not is_known(high.type):
            return nothing(node.span)
        shared = common_type(low.type, high.type)
        if shared is None:
            self._no_common("the bounds of a range", low, high)
            return nothing(node.span)
        if not is_number(shared):
            expressions.bag.add(types.not_numeric_range, node.span, expressions.converter.describe(shared))
            return nothing(node.span)
        return Typed(plan.RangeOf(convert(low, shared), convert(high, shared), node.span), RangeOf(shared))

    def _common(self, items: list[Typed]) -> Type | None:
        """Return the common type of a list's members; without one, report and return None."""
        shared = _element(items[0])
        for item in items[1:]:
            both = common_type(shared, _element(item))
            if both is None:
                self._no_common("the members of a list", items[0], item)
                return None
            shared = both
        return shared

    def _no_common(self, what: str, left: Typed, right: Typed) -> None:
        describe = self._expressions.converter.describe
        shown = describe(left.type), describe(right.type)
        self._expressions.bag.add(types.no_common_type, right.expression.span, left.expression.span, what, *shown)

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
            expressions.bag.add(methods.impossible_cast, node.span, describe(operand.type), describe(target))
            return nothing(node.span)
        return Typed(plan.Cast(operand.expression, plan_type(target, expressions.program), node.span), target)


def _element(item: Typed) -> Type:
    """Return the type that an item contributes to a list."""
    return item.type.element if isinstance(item.type, ListOf) else item.type


def _are_bare_numbers(items: list[Typed], element: Type | None) -> bool:
    """Return whether all items are literal numbers without units, although a physical type is expected."""
    return isinstance(element, Quantity) and all(
        is_plain_number(item.type) and isinstance(item.expression, plan.Literal) for item in items
    )


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
