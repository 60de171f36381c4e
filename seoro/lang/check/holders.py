"""What stands in front of a dot: a value, or a label for what was invoked last under it (7.6.2.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.check.compositions import DURATION, duration_of
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.labels import WrongLabel, names_of
from seoro.lang.symbols import FieldSymbol
from seoro.lang.types import Structured

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions
    from seoro.lang.check.scopes import Scope


class Holders:
    """Elaborates what stands in front of dots.

    Args:
        expressions: For values.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions

    def find(self, node: ast.Expression, scope: Scope) -> Typed:
        """What has the field or the method behind the dot."""
        names, labels = names_of(node), scope.labels
        if labels is None or not names or self._is_value(names[0], scope):
            return self._expressions.value(node, scope)
        path = labels.path(names)
        if path is None:
            return nothing(node.span)
        type_ = None if isinstance(path, WrongLabel) else labels.type_of(path)
        if isinstance(path, WrongLabel) or type_ is None:
            return self._expressions.value(node, scope)
        return Typed(plan.Labelled(path, node.span), type_)

    def _is_value(self, name: ast.Name, scope: Scope) -> bool:
        """Whether a name stands for a value, which goes before a label."""
        if name.namespace is None and name.text in scope.bindings:
            return True
        lookup = self._expressions.lookup
        is_field = lookup.member(scope.space, scope.fields, name) is not None
        return is_field or lookup.global_parameter(scope.space, name) is not None


def implicit_duration(holder: Typed, name: ast.Name) -> FieldSymbol | None:
    """The `duration` of an invocation that is `it`, where no such field is declared (7.6.2.4.1)."""
    is_it = isinstance(holder.expression, plan.Binding) and holder.expression.name == "it"
    if not is_it or not isinstance(holder.type, Structured) or name.namespace is not None or name.text != DURATION:
        return None
    return duration_of(holder.type.symbol)
