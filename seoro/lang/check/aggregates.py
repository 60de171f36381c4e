"""Lists, ranges and `? :`: values that are made of values of one type (7.4.2.7.4, 7.4.2.8.1, 7.4.2.9)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.check.convert import Typed, common_type, nothing
from seoro.lang.diagnostics import syntax
from seoro.lang.diagnostics import types as messages
from seoro.lang.source import Span
from seoro.lang.types import (
    BOOL,
    UNKNOWN,
    ListOf,
    Quantity,
    RangeOf,
    Type,
    is_known,
    is_number,
    is_plain_number,
)

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions
    from seoro.lang.check.scopes import Scope

MAX_CHAIN = 20_000  # of operands in a row


class Aggregates:
    """Elaborates aggregates.

    Args:
        expressions: For their parts, and for messages.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions

    def ternary(self, node: ast.TernaryOpExp, scope: Scope, expected: Type | None) -> Typed:
        """`c ? a : b`; a table, with many more on its last branch, is no recursion."""
        expressions, rows = self._expressions, [node]
        while isinstance(last := rows[-1].otherwise, ast.TernaryOpExp):
            rows.append(last)
        if len(rows) > MAX_CHAIN:
            expressions.bag.add(syntax.TooDeep(node.span, MAX_CHAIN))
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
        """`[a, b]`; a member that is a list itself is flattened where it is written out."""
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
        """A list of values, and of the members of those that are lists."""
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
            expressions.bag.add(messages.NotNumericRange(node.span, expressions.converter.describe(shared)))
            return nothing(node.span)
        return Typed(plan.RangeOf(convert(low, shared), convert(high, shared), node.span), RangeOf(shared))

    def _common(self, items: list[Typed]) -> Type | None:
        """The type of a list's members; None if there is none, which is reported."""
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
        spans = right.expression.span, left.expression.span
        message = messages.NoCommonType(*spans, what, describe(left.type), describe(right.type))
        self._expressions.bag.add(message)


def _element(item: Typed) -> Type:
    """The type of what an item adds to a list."""
    return item.type.element if isinstance(item.type, ListOf) else item.type


def _are_bare_numbers(items: list[Typed], element: Type | None) -> bool:
    """Whether all are numbers that are written out, without units, where a physical type is asked for."""
    return isinstance(element, Quantity) and all(
        is_plain_number(item.type) and isinstance(item.expression, plan.Literal) for item in items
    )
