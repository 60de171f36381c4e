"""Applications to arguments: structs, methods, and built-in operators (7.4.2.1)."""

from __future__ import annotations

from seoro.lang import ast, plan
from seoro.lang.check.builtins import Builtins
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.labels import AllLabels
from seoro.lang.check.lookup import candidates
from seoro.lang.check.methods import Methods
from seoro.lang.check.scopes import Scope
from seoro.lang.check.values import Values
from seoro.lang.diagnostics import methods as method_messages
from seoro.lang.diagnostics import names, types
from seoro.lang.diagnostics.behaviors import made_by_field
from seoro.lang.symbols import Kind, MethodSymbol, Structured, TypeSymbol, is_open
from seoro.lang.types import INT, UINT, is_known


class Calls:
    """Elaborates applications to arguments.

    Args:
        expressions: The expression checker.
        values: The structs to construct.
        methods: The methods to call.
        labels: The labels of all types.
    """

    def __init__(
        self, expressions: ExpressionChecker, values: Values, methods: Methods, labels: AllLabels
    ) -> None:
        self._expressions = expressions
        self._values = values
        self._methods = methods
        self._labels = labels
        self._builtins = Builtins(expressions)

    def application(self, node: ast.FunctionApplication, scope: Scope, is_directive: bool = False) -> Typed:
        """Elaborate `name(...)` or `base.name(...)`; methods need a result except in `call`."""
        match node.function:
            case ast.NameExpression(name):
                symbol = self._expressions.lookup.type(scope.space, name)
                if isinstance(symbol, TypeSymbol) and symbol.kind is Kind.STRUCT:
                    if self._expressions.strict:
                        self._expressions.bag.add(types.struct_constructor, node.span, name.text)
                    return self._values.from_arguments(symbol, node, scope)
                method = self._methods.own(name, scope)
                if method is not None:
                    receiver = plan.Binding("it", name.span) if scope.owner is None else None
                    return self._methods.call(method, receiver, node, scope, is_directive)
                return self._unknown_method(name, node, scope)
            case ast.FieldAccess(base, name):
                return self._call(base, name, node, scope, is_directive)
            case _:
                self._expressions.bag.add(types.not_callable, node.span, node.function.span.text)
                return nothing(node.span)

    def _call(
        self,
        base: ast.Expression,
        name: ast.Name,
        node: ast.FunctionApplication,
        scope: Scope,
        is_directive: bool,
    ) -> Typed:
        """Call a method or an operator of a value, or of the default value of a named struct."""
        found = self._default_of(base, scope) or self._labels.receiver(base, scope)
        if not is_known(found.type):
            return nothing(node.span)
        method: MethodSymbol | None
        known: tuple[str, ...] = ()
        if isinstance(found.type, Structured):
            methods = found.type.symbol.inventory.methods
            method = self._expressions.lookup.member(scope.space, methods, name)
            known = candidates(methods.values(), name) if method is None else ()
            is_hidden = is_open(found.type.symbol)
        else:
            built_in = self._builtins.apply(found, name, node, scope)
            if built_in is not None:
                return built_in
            method = self._methods.of_primitive(found.type, name, scope)
            if method is None and found.type == UINT and isinstance(found.expression, plan.Literal):
                method = self._methods.of_primitive(INT, name, scope)
            known, is_hidden = self._builtins.names(found.type), False
        if method is not None:
            receiver = None if isinstance(found.expression, plan.Self) else found.expression
            return self._methods.call(method, receiver, node, scope, is_directive)
        if not is_hidden and not self._expressions.program.is_unread(name.text):
            owner = self._expressions.converter.describe(found.type)
            self._expressions.bag.add(method_messages.unknown_method, name.span, owner, name.text, known)
        return nothing(node.span)

    def _default_of(self, base: ast.Expression, scope: Scope) -> Typed | None:
        """Return the default value of a struct that is named as a value: an extension."""
        if not isinstance(base, ast.NameExpression):
            return None
        name = base.name
        if self._expressions.is_value(name, scope):
            return None
        symbol = self._expressions.lookup.type(scope.space, name)
        if not isinstance(symbol, TypeSymbol) or symbol.kind is not Kind.STRUCT:
            return None
        if self._expressions.strict:
            self._expressions.bag.add(types.struct_constructor, base.span, name.text)
        arguments = ast.ArgumentList((), (), base.span)
        return self._values.from_arguments(symbol, ast.FunctionApplication(base, arguments, base.span), scope)

    def _unknown_method(self, name: ast.Name, node: ast.FunctionApplication, scope: Scope) -> Typed:
        if self._expressions.program.is_unread(name.text) or (scope.owner is not None and is_open(scope.owner)):
            return nothing(node.span)
        if any(key[2] == name.text for key in self._expressions.program.behaviors):
            hint = "invoke scenarios and actions below `do`"
            self._expressions.bag.add(types.not_callable, name.span, name.text, hint)
            return nothing(node.span)
        methods = scope.owner.inventory.methods if scope.owner is not None else {}
        known = tuple(method.text for method in methods.values())
        known += self._expressions.program.types_of(Kind.STRUCT)
        hint = self._construction(name, node, scope)
        self._expressions.bag.add(names.unknown_type, name.span, name.text, known, "method or struct", hint)
        return nothing(node.span)

    def _construction(self, name: ast.Name, node: ast.FunctionApplication, scope: Scope) -> str:
        """Return help on creating an actor; empty for anything else."""
        symbol = self._expressions.lookup.type(scope.space, name)
        if not isinstance(symbol, TypeSymbol) or symbol.kind is not Kind.ACTOR:
            return ""
        return made_by_field(name.text, [argument.name.text for argument in node.arguments.named])
