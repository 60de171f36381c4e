"""Built-in operators in method syntax: of lists (7.4.2.7), ranges (7.4.2.8.4) and strings (8.13)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from seoro.lang import ast, plan
from seoro.lang.check.arguments import Binding
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostics import behaviors, methods, types
from seoro.lang.members import MemberTable
from seoro.lang.namespaces import Home, Space
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol, ListOf, RangeOf, Type
from seoro.lang.types import BOOL, INT, STRING, UINT, UNKNOWN, is_known

_LIST_METHODS = ("size", *(operator.value for operator in plan.Bulk))
_STRING_METHODS: Mapping[plan.StringMethod, tuple[tuple[tuple[str, Type], ...], Type]] = {
    plan.StringMethod.LENGTH: ((), INT),
    plan.StringMethod.CONTAINS: ((("substring", STRING),), BOOL),
    plan.StringMethod.SUBSTRING: ((("start", INT), ("end", INT)), STRING),
    plan.StringMethod.SPLIT: ((("separator", STRING),), ListOf(STRING)),
    plan.StringMethod.JOIN: ((("parts", ListOf(STRING)),), STRING),
    plan.StringMethod.REPLACE: ((("old", STRING), ("new", STRING)), STRING),
    plan.StringMethod.TRIM: ((), STRING),
}  # parameters and results, as 8.13 declares them
_OPTIONAL = "end"
_STANDARD = Home(Space("std"), None)


class Builtins:
    """Elaborates built-in operators.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions

    def apply(self, base: Typed, name: ast.Name, node: ast.FunctionApplication, scope: Scope) -> Typed | None:
        """Elaborate `base.name(...)`; return None if `name` is not an operator."""
        is_prefixed = name.namespace is not None and base.type != STRING
        if is_prefixed or name.text not in self.names(base.type):
            return None
        match base.type:
            case ListOf(element):
                return self._of_list(base, element, name, node, scope)
            case RangeOf(element):
                self._take_nothing(name.text, node)
                return Typed(plan.Bound(plan.Side(name.text), base.expression, node.span), element)
            case _:
                return self._of_string(base, plan.StringMethod(name.text), node, scope)

    @staticmethod
    def names(type_: Type) -> tuple[str, ...]:
        """Return the names of a type's operators."""
        match type_:
            case ListOf():
                return _LIST_METHODS
            case RangeOf():
                return tuple(side.value for side in plan.Side)
            case _:
                return tuple(method.value for method in plan.StringMethod) if type_ == STRING else ()

    def _of_list(
        self, base: Typed, element: Type, name: ast.Name, node: ast.FunctionApplication, scope: Scope
    ) -> Typed:
        if name.text == "size":
            self._take_nothing(name.text, node)
            return Typed(plan.Size(base.expression, node.span), UINT)
        operator = plan.Bulk(name.text)
        arguments = node.arguments
        if len(arguments.positional) != 1 or arguments.named:
            self._expressions.bag.add(methods.invalid_operands, node.span, name.text, "one expression, about `it`")
            return nothing(node.span)
        inside = replace(scope, it=element, is_it_bound=True)
        argument = arguments.positional[0]
        is_map = operator is plan.Bulk.MAP
        body = self._expressions.value(argument, inside, None if is_map else BOOL)
        if not is_map:
            self._expressions.operators.truth(body, name.text, argument.span)
        elif isinstance(body.type, ListOf):
            self._expressions.bag.add(types.list_of_list, argument.span)
            return nothing(node.span)
        result = self._result(operator, element, body.type)
        made = plan.ForEach(operator, base.expression, body.expression, node.span)
        return Typed(made, result if is_known(result) else UNKNOWN)

    @staticmethod
    def _result(operator: plan.Bulk, element: Type, body: Type) -> Type:
        match operator:
            case plan.Bulk.FILTER:
                return ListOf(element)
            case plan.Bulk.FIRST_INDEX:
                return INT
            case plan.Bulk.COUNT:
                return UINT
            case plan.Bulk.HAS:
                return BOOL
            case plan.Bulk.MAP:
                return ListOf(body)

    def _of_string(
        self, base: Typed, method: plan.StringMethod, node: ast.FunctionApplication, scope: Scope
    ) -> Typed:
        declared, result = _STRING_METHODS[method]
        parameters: MemberTable[FieldSymbol] = MemberTable()
        for name, type_ in declared:
            parameters.add(_parameter(name, type_, node.span))
        given = Binding(self._expressions, method.value, parameters, scope).bind(node.arguments)
        for name in parameters:
            if name not in given and name != _OPTIONAL:
                self._expressions.bag.add(behaviors.missing_argument, node.span, method.value, name)
        arguments = tuple(given[name] for name in parameters if name in given)
        return Typed(plan.StringCall(method, base.expression, arguments, node.span), result)

    def _take_nothing(self, name: str, node: ast.FunctionApplication) -> None:
        if node.arguments.positional or node.arguments.named:
            self._expressions.bag.add(methods.invalid_operands, node.arguments.span, name, "no arguments")


def _parameter(name: str, type_: Type, span: Span) -> FieldSymbol:
    return FieldSymbol(name, type_, None, None, span, _STANDARD, name, _STANDARD.space.name)
