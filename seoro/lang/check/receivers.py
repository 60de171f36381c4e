"""Receivers before a dot: a value, or a label that denotes its last invocation (7.6.2.2)."""

from __future__ import annotations

from seoro.lang import ast, plan
from seoro.lang.check.compositions import DURATION, duration_of
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.labels import AllLabels, WrongLabel, names_of
from seoro.lang.check.scopes import Scope
from seoro.lang.symbols import FieldSymbol, Structured


class Receivers:
    """Elaborates the receivers before dots.

    Args:
        expressions: The expression checker.
        labels: The labels of all types.
    """

    def __init__(self, expressions: ExpressionChecker, labels: AllLabels) -> None:
        self._expressions = expressions
        self._labels = labels

    def find(self, node: ast.Expression, scope: Scope) -> Typed:
        """Elaborate the receiver of a field or method access."""
        if not scope.is_running or scope.owner is None:
            return self._expressions.value(node, scope)
        names, labels = names_of(node), self._labels.of(scope.owner)
        if not names or self._is_value(names[0], scope):
            return self._expressions.value(node, scope)
        path = labels.path(names)
        if path is None:
            return nothing(node.span)
        type_ = None if isinstance(path, WrongLabel) else labels.type_of(path)
        if isinstance(path, WrongLabel) or type_ is None:
            return self._expressions.value(node, scope)
        return Typed(plan.Labelled(path, node.span), type_)

    def _is_value(self, name: ast.Name, scope: Scope) -> bool:
        """Return whether a name denotes a value, which takes precedence over a label."""
        if name.namespace is None and name.text in scope.bindings:
            return True
        lookup = self._expressions.lookup
        is_field = lookup.member(scope.space, scope.fields, name) is not None
        return is_field or lookup.global_parameter(scope.space, name) is not None


def implicit_duration(holder: Typed, name: ast.Name) -> FieldSymbol | None:
    """Return the implicit `duration` of an invocation that `it` denotes (7.6.2.4.1)."""
    is_it = isinstance(holder.expression, plan.Binding) and holder.expression.name == "it"
    if not is_it or not isinstance(holder.type, Structured) or name.namespace is not None or name.text != DURATION:
        return None
    return duration_of(holder.type.symbol)
