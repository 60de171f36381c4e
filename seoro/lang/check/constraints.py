"""Constraints on parameters, removal of defaults (7.3.11), and paths: expressions that lead to a field."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from seoro.lang import ast, plan
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.scopes import Scope, duration_of
from seoro.lang.diagnostics import behaviors
from seoro.lang.program import Program
from seoro.lang.symbols import CompositionObject, FieldSymbol, ListOf, Structured, Type
from seoro.lang.types import BOOL


class Constraints:
    """Elaborates constraints.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions
        self._bag = expressions.bag

    def among(self, members: Iterable[ast.Node], scope: Scope) -> Iterator[plan.ConstraintMember]:
        """Elaborate the constraints among members; invalid ones are reported."""
        for node in members:
            match node:
                case ast.KeepConstraint():
                    found: plan.ConstraintMember | None = self._keep(node, scope)
                case ast.RemoveDefault():
                    found = self._remove_default(node, scope)
                case _:
                    continue
            if found is not None:
                yield found

    def _keep(self, node: ast.KeepConstraint, scope: Scope) -> plan.Constraint | None:
        errors = len(self._bag)
        condition = self._expressions.converted(node.constraint, BOOL, scope, "a constraint")
        if len(self._bag) > errors:
            return None
        paths = list(paths_in(condition, scope, self._expressions.program))
        variable = next((path for path in paths if leads_to_variable(path[1])), None)
        if variable is not None and all(leads_to_variable(fields) for _, fields in paths):
            span = variable[0].span
            self._bag.add(behaviors.constrained_variable, span, span.text, _variable(variable[1]).span)
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
            self._bag.add(behaviors.not_a_parameter, node.parameter.span, node.parameter.span.text, declared)
            return None
        return plan.RemoveDefault(parameter, node.span)


def _variable(fields: tuple[FieldSymbol, ...]) -> FieldSymbol:
    """Return the first variable on a path, else its last field."""
    return next((field for field in fields if field.is_variable), fields[-1])


def paths_in(
    expression: plan.Expression, scope: Scope, program: Program
) -> Iterator[tuple[plan.Expression, tuple[FieldSymbol, ...]]]:
    """Yield the paths in an expression, each with its fields."""
    pending = [expression]
    while pending:
        current = pending.pop()
        fields = fields_on(current, scope, program)
        if fields:
            yield current, fields
        if fields is None or isinstance(current, plan.Index):
            pending += plan.parts(current)


def fields_on(expression: plan.Expression, scope: Scope, program: Program) -> tuple[FieldSymbol, ...] | None:
    """Return the fields of a path; None for other expressions."""
    match expression:
        case plan.Field(name):
            return (scope.fields[name],) if name in scope.fields else None
        case plan.Global(name):
            return (program.globals_by_name[name],)
        case plan.Self() | plan.Binding():
            return ()
        case plan.Index(items):
            return fields_on(items, scope, program)
        case plan.Member(base, name):
            before = fields_on(base, scope, program)
            if before is None:
                return None
            type_ = before[-1].type if before else _type_of_root(base, scope)
            if isinstance(type_, ListOf):
                type_ = type_.element
            fields = _fields_of(type_)
            return (*before, fields[name]) if name in fields else None
        case _:
            return None


def _fields_of(type_: Type | None) -> Mapping[str, FieldSymbol]:
    match type_:
        case Structured(symbol):
            duration = duration_of(symbol)
            return (
                symbol.inventory.fields
                if duration is None
                else {**symbol.inventory.fields, duration.name: duration}
            )
        case CompositionObject(composition):
            return composition.parameters
        case _:
            return {}


def _type_of_root(base: plan.Expression, scope: Scope) -> Type | None:
    """Return the type of a path's root if it is not a field."""
    if isinstance(base, plan.Binding) and not (base.name == "it" and scope.is_it_bound):
        return scope.bindings.get(base.name)
    return scope.it


def leads_to_variable(fields: tuple[FieldSymbol, ...]) -> bool:
    """Return whether a path leads to a variable; the fields of a variable are variables, too (7.3.6.1.2)."""
    return any(field.is_variable for field in fields)
