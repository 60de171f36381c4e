"""What is applied to arguments: structs, methods, and operators that are written like them (7.4.2.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.check.builtins import Builtins
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.lookup import candidates
from seoro.lang.diagnostics import methods as method_messages
from seoro.lang.diagnostics import names
from seoro.lang.diagnostics import types as messages
from seoro.lang.symbols import Declaration, Kind, MethodSymbol, TypeSymbol, all_methods, is_open
from seoro.lang.types import INT, UINT, Structured, is_known

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions
    from seoro.lang.check.scopes import Scope


class Calls:
    """Elaborates applications to arguments.

    Args:
        expressions: For what is applied, and for messages.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._builtins = Builtins(expressions)

    def application(self, node: ast.FunctionApplication, scope: Scope, is_directive: bool = False) -> Typed:
        """`name(...)` or `base.name(...)`; only in a `call` directive, methods need no result."""
        match node.function:
            case ast.NameExpression(name):
                symbol = self._expressions.lookup.type(scope.space, name)
                if isinstance(symbol, TypeSymbol) and symbol.kind is Kind.STRUCT:
                    if self._expressions.strict:
                        self._expressions.bag.add(messages.StructConstructor(node.span, name.text))
                    return self._expressions.values.from_arguments(symbol, node, scope)
                method = self._expressions.methods.own(name, scope)
                if method is not None:
                    receiver = plan.Binding("it", name.span) if scope.owner is None else None
                    return self._expressions.methods.call(method, receiver, node, scope, is_directive)
                return self._unknown_method(name, node, scope)
            case ast.FieldAccess(base, name):
                return self._call(base, name, node, scope, is_directive)
            case _:
                self._expressions.bag.add(messages.NotCallable(node.span, node.function.span.text))
                return nothing(node.span)

    def _call(
        self,
        base: ast.Expression,
        name: ast.Name,
        node: ast.FunctionApplication,
        scope: Scope,
        is_directive: bool,
    ) -> Typed:
        """A method, or an operator like one, of a value; of a struct's name, of its default value."""
        found = self._default_of(base, scope) or self._expressions.holders.find(base, scope)
        if not is_known(found.type):
            return nothing(node.span)
        method: MethodSymbol | None
        known: tuple[str, ...] = ()
        if isinstance(found.type, Structured):
            methods = all_methods(found.type.symbol)
            method = self._expressions.lookup.member(scope.space, methods, name)
            known = candidates(methods.values(), name) if method is None else ()
            is_hidden = is_open(found.type.symbol)
        else:
            built_in = self._builtins.apply(found, name, node, scope)
            if built_in is not None:
                return built_in
            method = self._expressions.methods.of_primitive(found.type, name, scope)
            if method is None and found.type == UINT and isinstance(found.expression, plan.Literal):
                method = self._expressions.methods.of_primitive(INT, name, scope)
            known, is_hidden = self._builtins.names(found.type), False
        if method is not None:
            receiver = None if isinstance(found.expression, plan.Self) else found.expression
            return self._expressions.methods.call(method, receiver, node, scope, is_directive)
        if not is_hidden and not self._expressions.program.is_unread(name.text):
            owner = self._expressions.converter.describe(found.type)
            self._expressions.bag.add(method_messages.UnknownMethod(name.span, owner, name.text, known))
        return nothing(node.span)

    def _default_of(self, base: ast.Expression, scope: Scope) -> Typed | None:
        """The default value of a struct whose name stands in the place of a value: an extension."""
        if not isinstance(base, ast.NameExpression):
            return None
        name, lookup = base.name, self._expressions.lookup
        is_bound = name.namespace is None and name.text in scope.bindings
        if (
            is_bound
            or lookup.member(scope.space, scope.fields, name)
            or lookup.global_parameter(scope.space, name)
        ):
            return None
        symbol = lookup.type(scope.space, name)
        if not isinstance(symbol, TypeSymbol) or symbol.kind is not Kind.STRUCT:
            return None
        if self._expressions.strict:
            self._expressions.bag.add(messages.StructConstructor(base.span, name.text))
        arguments = ast.ArgumentList((), (), base.span)
        return self._expressions.values.from_arguments(
            symbol, ast.FunctionApplication(base, arguments, base.span), scope
        )

    def _unknown_method(self, name: ast.Name, node: ast.FunctionApplication, scope: Scope) -> Typed:
        if self._expressions.program.is_unread(name.text) or (scope.owner is not None and is_open(scope.owner)):
            return nothing(node.span)
        if any(key[2] == name.text for key in self._expressions.program.behaviors):
            hint = "scenarios and actions are invoked below `do`"
            self._expressions.bag.add(messages.NotCallable(name.span, name.text, hint))
            return nothing(node.span)
        methods = all_methods(scope.owner) if scope.owner is not None else {}
        known = tuple(method.text for method in methods.values())
        known += tuple(symbol.name for symbol in self._expressions.program.types.values() if _is_struct(symbol))
        hint = self._construction(name, node, scope)
        self._expressions.bag.add(names.UnknownType(name.span, name.text, known, "method or struct", hint))
        return nothing(node.span)

    def _construction(self, name: ast.Name, node: ast.FunctionApplication, scope: Scope) -> str:
        """How to make a value of what is applied, if it is an actor."""
        symbol = self._expressions.lookup.type(scope.space, name)
        if not isinstance(symbol, TypeSymbol) or symbol.kind is not Kind.ACTOR:
            return ""
        return made_by_field(name.text, [argument.name.text for argument in node.arguments.named])


def made_by_field(actor: str, parameters: Sequence[str]) -> str:
    """Help for an actor that is written as if it had a constructor.

    Args:
        actor: Its name.
        parameters: The names of its fields that get a value.
    """
    text = f"actors are made by a field: `<name>: {actor}`"
    if not parameters:
        return text
    return f"{text} with a block `with:` that has `keep(it.{parameters[0]} == <value>)`"


def _is_struct(symbol: Declaration) -> bool:
    return isinstance(symbol, TypeSymbol) and symbol.kind is Kind.STRUCT
