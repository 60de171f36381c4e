"""Methods: their bodies, and calls of them (7.3.7, 7.4.2.1).

A run selects the implementation of a call by the type of the value. Here the declared type determines the
signature.
"""

from __future__ import annotations

from functools import cached_property
from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check.arguments import Binding
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.plan_types import plan_type
from seoro.lang.check.scopes import Scope, scope_of
from seoro.lang.diagnostics import behaviors, names
from seoro.lang.diagnostics import methods as method_messages
from seoro.lang.frozen import replaced
from seoro.lang.source import Span
from seoro.lang.symbols import MethodSymbol, Primitive, Type
from seoro.lang.types import UNKNOWN


class Methods:
    """Elaborates methods.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions
        self._elaborated: dict[MethodSymbol, plan.Method] = {}
        self._open: set[MethodSymbol] = set()

    def elaborate_all(self) -> None:
        """Elaborate all methods, and add them to the methods of the plan."""
        program = self._expressions.program
        for method in self._all:
            program.methods.add(_type_name(method), method.name, self._method(method))

    def implementations(self, name: str) -> list[plan.Method]:
        """Return all elaborated implementations of a method."""
        return [self._method(found) for found in self._by_name.get(name, []) if found not in self._open]

    @cached_property
    def _all(self) -> list[MethodSymbol]:
        program = self._expressions.program
        found = [method for symbol in program.structured() for method in symbol.methods.values()]
        return [*found, *(method for methods in program.primitives.values() for method in methods.values())]

    @cached_property
    def _by_name(self) -> dict[str, list[MethodSymbol]]:
        found: dict[str, list[MethodSymbol]] = {}
        for method in self._all:
            found.setdefault(method.name, []).append(method)
        return found

    # ------------------------------------------------------------ calls

    def own(self, name: ast.Name, scope: Scope) -> MethodSymbol | None:
        """Find the method of a name without a receiver."""
        if scope.owner is not None:
            return self._expressions.lookup.member(scope.space, scope.owner.inventory.methods, name)
        return self.of_primitive(scope.it, name, scope) if scope.it is not None else None

    def of_primitive(self, type_: Type, name: ast.Name, scope: Scope) -> MethodSymbol | None:
        """Find a method of a primitive type."""
        if not isinstance(type_, Primitive):
            return None
        methods = self._expressions.program.primitives.get(type_.name)
        return self._expressions.lookup.member(scope.space, methods, name) if methods is not None else None

    def call(
        self,
        method: MethodSymbol,
        receiver: plan.Expression | None,
        node: ast.FunctionApplication,
        scope: Scope,
        is_directive: bool,
    ) -> Typed:
        """Build the call of a method; without a receiver, of the instance of the scope.

        In a `call` directive, the method needs no result.
        """
        expressions = self._expressions
        given = Binding(expressions, method.text, method.parameters, scope).bind(node.arguments)
        for parameter in method.parameters.values():
            if parameter.default is None and parameter.name not in given:
                expressions.bag.add(behaviors.missing_argument, node.span, method.text, parameter.name)
        if method.result is None and not is_directive:
            expressions.bag.add(method_messages.no_result, node.span, method.text)
            return nothing(node.span)
        call = plan.Call(receiver, method.name, tuple(given.items()), node.span)
        return Typed(call, method.result if method.result is not None else UNKNOWN)

    # ------------------------------------------------------------ bodies

    def _method(self, symbol: MethodSymbol) -> plan.Method:
        if symbol in self._elaborated:
            return self._elaborated[symbol]
        self._open.add(symbol)
        scope = self._scope(symbol)
        bindings = dict(scope.bindings)
        scope = replaced(scope, bindings=bindings)  # a default can name the parameters before it
        parameters: list[tuple[str, plan.Expression | None]] = []
        for parameter in symbol.parameters.values():
            default: plan.Expression | None = None
            if parameter.default is not None:
                inside = replaced(scope, space=parameter.home.space)
                context = f"`{parameter.name}`"
                default = self._expressions.converted(parameter.default, parameter.type, inside, context)
            parameters.append((parameter.name, default))
            bindings[parameter.name] = parameter.type
        body = self._body(symbol, scope)
        result = plan_type(symbol.result, self._expressions.program) if symbol.result is not None else None
        made = plan.Method(symbol.text, tuple(parameters), result, body, symbol.span)
        self._open.remove(symbol)
        self._elaborated[symbol] = made
        return made

    def _scope(self, symbol: MethodSymbol) -> Scope:
        if symbol.owner is not None:
            return scope_of(symbol.owner, symbol.home)
        return Scope(None, symbol.home.space, it=symbol.receiver, is_it_bound=True)

    def _body(self, symbol: MethodSymbol, scope: Scope) -> plan.Expression | plan.External | plan.Undefined:
        expressions = self._expressions
        match symbol.implementation:
            case ast.ExpressionMethod(value, span):
                if symbol.result is None:
                    return expressions.value(value, scope).expression
                context = f"the result of `{symbol.text}`"
                return expressions.converted(value, symbol.result, scope, context)
            case ast.UndefinedMethod(span):
                return plan.Undefined(span)
            case ast.ExternalMethod(path, arguments, span):
                return self._external(symbol, path, arguments, span, scope)
            case _:
                assert_never(symbol.implementation)

    def _external(
        self, symbol: MethodSymbol, path: tuple[str, ...], arguments: ast.ArgumentList, span: Span, scope: Scope
    ) -> plan.External:
        expressions = self._expressions
        if len(path) < 2:
            expressions.bag.add(method_messages.invalid_function_path, span, ".".join(path))
        positional = tuple(self._argument(value, scope) for value in arguments.positional)
        named: dict[str, plan.Argument] = {}
        for argument in arguments.named:
            name = argument.name.text
            if name in named:
                expressions.bag.add(names.duplicate, argument.name.span, "argument", name, named[name].value.span)
            named[name] = self._argument(argument.value, scope)
        parameters = tuple(
            (parameter.name, plan_type(parameter.type, expressions.program))
            for parameter in symbol.parameters.values()
        )
        return plan.External(".".join(path), positional, tuple(named.items()), parameters, span)

    def _argument(self, value: ast.Expression, scope: Scope) -> plan.Argument:
        found = self._expressions.value(value, scope)
        return plan.Argument(found.expression, plan_type(found.type, self._expressions.program))


def _type_name(method: MethodSymbol) -> str:
    """Return the name in the plan of the type that has a method."""
    if method.owner is None:
        assert isinstance(method.receiver, Primitive)
        return method.receiver.name
    return method.owner.name_in_plan
