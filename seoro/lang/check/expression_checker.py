"""Interface of the expression checker, which the checks of single kinds of expressions use for operands."""

from __future__ import annotations

from abc import ABC, abstractmethod

from seoro.lang import ast, plan
from seoro.lang.check.convert import Converter, Typed, nothing
from seoro.lang.check.lookup import Lookup
from seoro.lang.check.operators import Operators
from seoro.lang.check.resolve import Resolver
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import syntax
from seoro.lang.namespaces import Space
from seoro.lang.program import Program
from seoro.lang.symbols import Type

MAX_DEPTH = 120  # of nested expressions


class ExpressionChecker(ABC):
    """Gives expressions their types; `Expressions` knows the kinds of expressions.

    Args:
        program: The program.
        bag: The messages.
        strict: Whether to report extensions to the standard.
    """

    def __init__(self, program: Program, bag: Bag, strict: bool) -> None:
        self.program = program
        self.bag = bag
        self.strict = strict
        self.lookup = Lookup(program, bag)
        self.converter = Converter(program, bag, strict)
        self.operators = Operators(program, self.converter, bag, strict)
        self._resolver = Resolver(program, bag)
        self._depth = 0

    def converted(self, node: ast.Expression, target: Type, scope: Scope, context: str = "") -> plan.Expression:
        """Elaborate an expression and convert it to a type."""
        return self.converter.convert(self.value(node, scope, target), target, context)

    def value(self, node: ast.Expression, scope: Scope, expected: Type | None = None) -> Typed:
        """Elaborate an expression."""
        if self._depth >= MAX_DEPTH:
            self.bag.add(syntax.too_deep, node.span, MAX_DEPTH)
            return nothing(node.span)
        self._depth += 1
        try:
            found = self._value(node, scope, expected)
            if self.program.recorder is not None:
                self.program.recorder.value(node.span, found.type)
            return found
        finally:
            self._depth -= 1

    @abstractmethod
    def _value(self, node: ast.Expression, scope: Scope, expected: Type | None) -> Typed:
        """Elaborate an expression by its kind."""

    def is_value(self, name: ast.Name, scope: Scope) -> bool:
        """Return whether a name denotes a value, which takes precedence over a label."""
        if name.namespace is None and name.text in scope.bindings:
            return True
        is_field = self.lookup.member(scope.space, scope.fields, name) is not None
        return is_field or self.lookup.global_parameter(scope.space, name) is not None

    def type_of(self, declarator: ast.TypeDeclarator, space: Space) -> Type:
        """Return the type of a declarator."""
        return self._resolver.type_of(declarator, space)
