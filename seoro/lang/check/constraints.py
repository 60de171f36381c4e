"""Constraints: what has to be true of parameters, and which defaults are void (7.3.11)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.diagnostics import constraints as messages
from seoro.lang.symbols import FieldSymbol, all_fields
from seoro.lang.types import BOOL, ListOf, Structured, Type

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions, Scope


class Constraints:
    """Elaborates constraints.

    Args:
        expressions: For their conditions, and for messages.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._bag = expressions.bag

    def member(self, node: ast.ConstraintDeclaration, scope: Scope) -> plan.ConstraintMember | None:
        """A constraint; None if it is wrong, which is reported."""
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
        paths = list(self._paths(condition, scope))
        variable = next((path for path in paths if _is_variable(path[1])), None)
        if variable is not None and all(_is_variable(fields) for _, fields in paths):
            span = variable[0].span
            self._bag.add(messages.ConstrainedVariable(span, span.text, _variable(variable[1]).span))
            return None
        return plan.Constraint(condition, node.qualifier == "default", node.span)

    def _remove_default(self, node: ast.RemoveDefault, scope: Scope) -> plan.RemoveDefault | None:
        errors = len(self._bag)
        parameter = self._expressions.value(node.parameter, scope).expression
        if len(self._bag) > errors:
            return None
        fields = self._path(parameter, scope)
        if not fields or _is_variable(fields):
            declared = _variable(fields).span if fields else None
            self._bag.add(messages.NoParameter(node.parameter.span, node.parameter.span.text, declared))
            return None
        return plan.RemoveDefault(parameter, node.span)

    # ------------------------------------------------------------ paths

    def _paths(
        self, expression: plan.Expression, scope: Scope
    ) -> Iterator[tuple[plan.Expression, tuple[FieldSymbol, ...]]]:
        """The paths to fields in an expression, each with the fields on its way."""
        pending = [expression]
        while pending:
            current = pending.pop()
            fields = self._path(current, scope)
            if fields:
                yield current, fields
            if fields is None or isinstance(current, plan.Index):
                pending += plan.parts(current)

    def _path(self, expression: plan.Expression, scope: Scope) -> tuple[FieldSymbol, ...] | None:
        """The fields on the way of a path; None if the expression is no path."""
        match expression:
            case plan.Field(name):
                return (scope.fields[name],) if name in scope.fields else None
            case plan.Global(name):
                found = self._expressions.program.globals.values()
                return tuple(field for field in found if field.name == name)
            case plan.Self() | plan.Binding():
                return ()
            case plan.Index(items):
                return self._path(items, scope)
            case plan.Member(base, name):
                before = self._path(base, scope)
                if before is None:
                    return None
                type_ = before[-1].type if before else self._type_of_root(base, scope)
                if isinstance(type_, ListOf):
                    type_ = type_.element
                fields = all_fields(type_.symbol) if isinstance(type_, Structured) else {}
                return (*before, fields[name]) if name in fields else None
            case _:
                return None

    @staticmethod
    def _type_of_root(base: plan.Expression, scope: Scope) -> Type | None:
        """The type of what a path begins with, where that is no field."""
        if isinstance(base, plan.Binding) and not (base.name == "it" and scope.is_it_bound):
            return scope.bindings.get(base.name)
        return scope.it


def _is_variable(fields: tuple[FieldSymbol, ...]) -> bool:
    """Whether a path leads to a variable; the fields of a variable are variables themselves (7.3.6.1.2)."""
    return any(field.is_variable for field in fields)


def _variable(fields: tuple[FieldSymbol, ...]) -> FieldSymbol:
    """The variable on a path; the last field if there is none."""
    return next((field for field in fields if field.is_variable), fields[-1])
