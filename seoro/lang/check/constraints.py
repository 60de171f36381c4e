"""Constraints on parameters, and removal of defaults (7.3.11)."""

from __future__ import annotations

from seoro.lang import ast, plan
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.paths import fields_on, leads_to_variable, paths_in
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostics import constraints as messages
from seoro.lang.symbols import FieldSymbol
from seoro.lang.types import BOOL


class Constraints:
    """Elaborates constraints.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions
        self._bag = expressions.bag

    def member(self, node: ast.ConstraintDeclaration, scope: Scope) -> plan.ConstraintMember | None:
        """Elaborate a constraint; report an invalid one and return None."""
        match node:
            case ast.KeepConstraint():
                return self._keep(node, scope)
            case ast.RemoveDefault():
                return self._remove_default(node, scope)

    def _keep(self, node: ast.KeepConstraint, scope: Scope) -> plan.Constraint | None:
        errors = len(self._bag)
        condition = self._expressions.converted(node.constraint, BOOL, scope, "a constraint")
        if len(self._bag) > errors:
            return None
        paths = list(paths_in(condition, scope, self._expressions.program))
        variable = next((path for path in paths if leads_to_variable(path[1])), None)
        if variable is not None and all(leads_to_variable(fields) for _, fields in paths):
            span = variable[0].span
            self._bag.add(messages.constrained_variable, span, span.text, _variable(variable[1]).span)
            return None
        return plan.Constraint(condition, node.qualifier == "default", node.span)

    def _remove_default(self, node: ast.RemoveDefault, scope: Scope) -> plan.RemoveDefault | None:
        errors = len(self._bag)
        parameter = self._expressions.value(node.parameter, scope).expression
        if len(self._bag) > errors:
            return None
        fields = fields_on(parameter, scope, self._expressions.program)
        if not fields or leads_to_variable(fields):
            declared = _variable(fields).span if fields else None
            self._bag.add(messages.not_a_parameter, node.parameter.span, node.parameter.span.text, declared)
            return None
        return plan.RemoveDefault(parameter, node.span)


def _variable(fields: tuple[FieldSymbol, ...]) -> FieldSymbol:
    """Return the first variable on a path, else its last field."""
    return next((field for field in fields if field.is_variable), fields[-1])
