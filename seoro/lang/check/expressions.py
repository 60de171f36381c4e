"""Fourth pass: type expressions, and convert them to expressions of the plan (7.4).

`expected` is only a hint. It decides between equal member names of several enumerations, gives elements of a list
their type, and decides whether an integer literal is an `int`. `Converter.convert` then checks the type.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar, assert_never

from seoro.lang import ast, plan, symbols
from seoro.lang.check import (
    aggregates,
    applications,
    arguments,
    calls,
    constraints,
    defaults,
    labels,
    methods,
    references,
    values,
)
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.lookup import candidates
from seoro.lang.check.scopes import ANY_BEHAVIOR, OVERLAP_KIND, Scope
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import names, syntax, types
from seoro.lang.escapes import unknown_escapes
from seoro.lang.members import MemberTable
from seoro.lang.program import Program
from seoro.lang.source import Span
from seoro.lang.traits import Trait
from seoro.lang.types import BOOL, FLOAT, INT, STRING, UINT, is_integer, is_known, is_number

Operation = TypeVar("Operation", ast.Arithmetic, ast.Relation, ast.Logic)


class Expressions(ExpressionChecker):
    """Elaborates expressions.

    Args:
        program: The program.
        bag: Bag for messages.
        strict: Whether to report extensions to the standard.
        traits: Traits of parameters in Python implementations of actions and modifiers.
    """

    def __init__(
        self, program: Program, bag: Bag, strict: bool, traits: arguments.Traits = arguments.NO_TRAITS
    ) -> None:
        super().__init__(program, bag, strict)
        self.labels = labels.AllLabels(self)
        self.methods = methods.Methods(self)
        self.constraints = constraints.Constraints(self)
        self.defaults = defaults.Defaults(self, self.methods)
        self.values = values.Values(self, self.constraints, self.defaults)
        self.calls = calls.Calls(self, self.values, self.methods, self.labels)
        self.references = references.References(self, self.methods, self.labels)
        self.aggregates = aggregates.Aggregates(self)
        self.applications = applications.Applications()
        self._traits = traits

    def _value(self, node: ast.Expression, scope: Scope, expected: symbols.Type | None) -> Typed:
        match node:
            case ast.IntegerLiteral(value, span):
                return Typed(plan.Literal(value, span), _integer_type(value, expected))
            case ast.FloatLiteral(number, span):
                return Typed(plan.Literal(number, span), FLOAT)
            case ast.PhysicalLiteral():
                return self.references.physical(node)
            case ast.BoolLiteral(truth, span):
                return Typed(plan.Literal(truth, span), BOOL)
            case ast.StringLiteral(text, span):
                self._check_escapes(span)
                return Typed(plan.Literal(text, span), STRING)
            case ast.EnumValueReference():
                return self.references.enum_value(node, scope)
            case ast.NameExpression(name):
                return self.references.name(name, scope, expected)
            case ast.FieldAccess():
                return self._field_access(node, scope)
            case ast.ElementAccess():
                return self._element(node, scope)
            case ast.FunctionApplication():
                return self.calls.application(node, scope)
            case ast.Negation(operand, span):
                return self.operators.negate(self.value(operand, scope, _signed(expected)), span)
            case ast.Inversion(operand, span):
                truth_ = self.operators.truth(self.value(operand, scope, BOOL), "not", operand.span)
                return Typed(plan.Not(truth_, span), BOOL)
            case ast.Arithmetic():
                return self._arithmetic(node, scope, expected)
            case ast.Relation():
                return self._relations(node, scope)
            case ast.Logic():
                return self._logic(node, scope)
            case ast.TernaryOpExp():
                return self.aggregates.ternary(node, scope, expected)
            case ast.ListConstructor():
                return self.aggregates.list_of(node, scope, expected)
            case ast.RangeConstructor():
                return self.aggregates.range_of(node, scope, expected)
            case ast.It(span):
                return self.references.it(span, scope)
            case ast.CastExp():
                return self.aggregates.cast(node, scope)
            case ast.TypeTestExp():
                return self.aggregates.test(node, scope)
            case _:
                assert_never(node)

    def _check_escapes(self, literal: Span) -> None:
        for start, end in unknown_escapes(literal.text):
            self.bag.add(syntax.unknown_escape, Span(literal.file, literal.start + start, literal.start + end))

    def traits_of(self, symbol: symbols.TypeSymbol) -> Mapping[str, Trait]:
        """Return the traits of parameters in the Python implementation of an action or a modifier."""
        return self._traits.get((symbol.kind, symbol.plan_name), {})

    # ------------------------------------------------------------ postfix operators

    def _field_access(self, node: ast.FieldAccess, scope: Scope) -> Typed:
        base = self.labels.receiver(node.base, scope)
        name = node.name
        match base.type:
            case symbols.Structured(symbol):
                fields = symbol.inventory.fields
                owner = f"`{symbol.name}`"
            case symbols.EventObject(event):
                fields = event.parameters
                owner = f"event `{event.name}`"
            case symbols.CompositionObject(composition):
                fields = composition.parameters
                owner = f"`{composition.name}`"
            case _:
                if is_known(base.type):
                    self.bag.add(types.no_fields, node.base.span, self.converter.describe(base.type))
                return nothing(node.span)
        found = self._member_field(base.type, fields, name, scope) or labels.implicit_duration(base, name)
        if found is not None:
            if isinstance(base.expression, plan.Self):
                return Typed(plan.Field(found.name, node.span), found.type)
            return Typed(plan.Member(base.expression, found.name, node.span), found.type)
        if isinstance(base.type, symbols.Structured) and symbols.is_open(base.type.symbol):
            return nothing(node.span)
        if not self.program.is_unread(name.text):
            is_composition = isinstance(base.type, symbols.CompositionObject)
            known = tuple(fields) if is_composition else candidates(fields.values(), name)
            hint = (
                "declare the modifier `of` a scenario or an action to use its fields"
                if base.type == ANY_BEHAVIOR
                else ""
            )
            self.bag.add(names.unknown_field, name.span, owner, name.text, known, hint)
        return nothing(node.span)

    def _member_field(
        self, type_: symbols.Type, fields: MemberTable[symbols.FieldSymbol], name: ast.Name, scope: Scope
    ) -> symbols.FieldSymbol | None:
        """Find the field of a name; parameters of events need no prefix, those of compositions have none."""
        if not isinstance(type_, symbols.CompositionObject):
            find = self.lookup.parameter if isinstance(type_, symbols.EventObject) else self.lookup.member
            return find(scope.space, fields, name)
        found = fields.get(name.text) if name.namespace is None else None
        if found is not None and type_ == ANY_BEHAVIOR and scope.owner is not None:
            self.applications.use(scope.owner, found.name, name.span)
        return found

    def _element(self, node: ast.ElementAccess, scope: Scope) -> Typed:
        base = self.value(node.base, scope)
        index = self.value(node.position, scope, INT)
        if is_known(index.type) and not is_integer(index.type):
            self.bag.add(types.invalid_index, node.position.span, self.converter.describe(index.type))
        if isinstance(base.type, symbols.ListOf):
            return Typed(plan.Index(base.expression, index.expression, node.span), base.type.element)
        if is_known(base.type):
            self.bag.add(types.not_a_list, node.base.span, self.converter.describe(base.type))
        return nothing(node.span)

    # ------------------------------------------------------------ operators

    def _chain(self, node: Operation) -> list[Operation]:
        """Return the operators of a chain, from its left end; report too many and return none.

        Chains may be long, so recursion would be too deep.
        """
        chain, kind = [node], type(node)
        while isinstance(left := chain[-1].left, kind):
            chain.append(left)
        if len(chain) > aggregates.MAX_CHAIN:
            self.bag.add(syntax.too_deep, node.span, aggregates.MAX_CHAIN)
            return []
        return chain[::-1]

    def _arithmetic(self, node: ast.Arithmetic, scope: Scope, expected: symbols.Type | None) -> Typed:
        chain = self._chain(node)
        if not chain:
            return nothing(node.span)
        hint = expected if expected == UINT else None
        wants_int = expected is not None and is_number(expected) and expected != UINT
        first = chain[0].left
        result = self.value(first, scope, hint)
        only_literals = isinstance(first, ast.IntegerLiteral)
        for step in chain:
            right = self.value(step.right, scope, hint)
            only_literals = only_literals and isinstance(step.right, ast.IntegerLiteral)
            result = self.operators.arithmetic(step, result, right, wants_int and only_literals)
        return result

    def _relations(self, node: ast.Relation, scope: Scope) -> Typed:
        chain = self._chain(node)
        if not chain:
            return nothing(node.span)
        result: Typed | None = None
        for step in chain:
            left, right = self._operands(step, result, scope)
            result = self.operators.relation(step, left, right)
        assert result is not None
        return result

    def _operands(self, node: ast.Relation, left: Typed | None, scope: Scope) -> tuple[Typed, Typed]:
        """Elaborate the operands of a relation; members of enumerations get their type from the other side."""
        is_in = node.operator == "in"
        is_right_open = self.references.is_open_member(node.right, scope)
        if left is None and not is_right_open and self.references.is_open_member(node.left, scope):
            right = self.value(node.right, scope)
            hint = right.type.element if is_in and isinstance(right.type, symbols.ListOf) else right.type
            return self.value(node.left, scope, hint), right
        if left is None:
            left = self.value(node.left, scope)
        wanted = symbols.ListOf(left.type) if is_in and isinstance(node.right, ast.ListConstructor) else left.type
        is_hinted = is_right_open or left.type == OVERLAP_KIND
        return left, self.value(node.right, scope, wanted if is_hinted else None)

    def _logic(self, node: ast.Logic, scope: Scope) -> Typed:
        chain = self._chain(node)
        if not chain:
            return nothing(node.span)
        result = self.value(chain[0].left, scope, BOOL)
        for step in chain:
            left = self.operators.truth(result, step.operator, step.left.span)
            right = self.operators.truth(self.value(step.right, scope, BOOL), step.operator, step.right.span)
            result = Typed(plan.Logic(step.operator, left, right, step.span), BOOL)
        return result


def _integer_type(value: int, expected: symbols.Type | None) -> symbols.Type:
    if value < 0:
        return INT
    return INT if expected in (INT, FLOAT) and value < 2**63 else UINT


def _signed(expected: symbols.Type | None) -> symbols.Type | None:
    return INT if expected == UINT else expected
