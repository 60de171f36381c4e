"""Third pass: expressions get their types and become expressions of the plan (7.4).

`expected` is a hint, not a demand: it decides between members of several enumerations with one name, gives the
elements of a list their type, and says whether an integer literal is meant as `int`. Whether the value fits its
place is for `Converter.convert`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check.aggregates import Aggregates
from seoro.lang.check.convert import Converter, Typed, nothing
from seoro.lang.check.operators import Operators
from seoro.lang.check.plan_types import enum_value
from seoro.lang.check.values import Values
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import names, syntax
from seoro.lang.diagnostics import types as messages
from seoro.lang.diagnostics.unsupported import Construct, NotSupported
from seoro.lang.source import Span
from seoro.lang.symbols import (
    EnumSymbol,
    FieldSymbol,
    Kind,
    Program,
    QuantitySymbol,
    TypeSymbol,
    all_fields,
    is_open,
    lineage,
)
from seoro.lang.types import (
    BOOL,
    FLOAT,
    INT,
    STRING,
    UINT,
    Enumeration,
    EventObject,
    ListOf,
    Structured,
    Type,
    is_integer,
    is_known,
    is_number,
    quantity,
)
from seoro.lang.units import to_si

MAX_DEPTH = 120  # of nested expressions
MAX_CHAIN = 600  # of operands in a row


@dataclass(frozen=True)
class Scope:
    """What names mean where an expression stands.

    Args:
        owner: The type whose fields can be named; None if there is none.
        namespace: The namespace of the text.
        bindings: `actor`, and the event objects of `as` clauses.
    """

    owner: TypeSymbol | None
    namespace: str
    bindings: Mapping[str, Type] = field(default_factory=dict)
    fields: Mapping[str, FieldSymbol] = field(default_factory=dict)


def scope_of(owner: TypeSymbol) -> Scope:
    """The scope of the members of a type."""
    bindings: dict[str, Type] = {"actor": Structured(owner.actor)} if owner.actor is not None else {}
    return Scope(owner, owner.home.namespace, bindings, all_fields(owner))


class Expressions:
    """Elaborates expressions.

    Args:
        program: The program.
        bag: Where messages go.
        strict: Whether to report extensions to the standard.
    """

    def __init__(self, program: Program, bag: Bag, strict: bool) -> None:
        self.program = program
        self.bag = bag
        self.converter = Converter(program, bag, strict)
        self.operators = Operators(program, self.converter, bag)
        self.values = Values(self)
        self.aggregates = Aggregates(self)
        self.strict = strict
        self._depth = 0

    def converted(
        self, node: ast.Expression, target: Type, scope: Scope, context: str = "", is_argument: bool = False
    ) -> plan.Expression:
        """An expression as a value of a type."""
        return self.converter.convert(self.value(node, scope, target), target, context, is_argument)

    def value(self, node: ast.Expression, scope: Scope, expected: Type | None = None) -> Typed:
        """An expression with its type."""
        if self._depth >= MAX_DEPTH:
            self.bag.add(syntax.TooDeep(node.span, MAX_DEPTH))
            return nothing(node.span)
        self._depth += 1
        try:
            return self._value(node, scope, expected)
        finally:
            self._depth -= 1

    def _value(self, node: ast.Expression, scope: Scope, expected: Type | None) -> Typed:
        match node:
            case ast.IntegerLiteral(value, span):
                return Typed(plan.Literal(value, span), _integer_type(value, expected))
            case ast.FloatLiteral(number, span):
                return Typed(plan.Literal(number, span), FLOAT)
            case ast.PhysicalLiteral():
                return self._physical(node)
            case ast.BoolLiteral(truth, span):
                return Typed(plan.Literal(truth, span), BOOL)
            case ast.StringLiteral(text, span):
                return Typed(plan.Literal(text, span), STRING)
            case ast.EnumValueReference():
                return self._enum_value(node, scope)
            case ast.NameExpression(name):
                return self._name(name, scope, expected)
            case ast.FieldAccess():
                return self._field_access(node, scope)
            case ast.ElementAccess():
                return self._element(node, scope)
            case ast.FunctionApplication():
                return self._application(node, scope)
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
                return self.refuse(span, Construct.IT)
            case ast.CastExp(span=span):
                return self.refuse(span, Construct.CAST)
            case ast.TypeTestExp(span=span):
                return self.refuse(span, Construct.TYPE_TEST)
            case _:
                assert_never(node)

    def refuse(self, span: Span, construct: Construct, name: str = "") -> Typed:
        """Report what is not supported yet."""
        self.bag.add(NotSupported(span, construct, name))
        return nothing(span)

    # ------------------------------------------------------------ literals and names

    def _physical(self, node: ast.PhysicalLiteral) -> Typed:
        unit = self.program.units.get(node.unit.text)
        if unit is None:
            self.bag.add(names.UnknownUnit(node.unit.span, node.unit.text, tuple(self.program.units)))
            return nothing(node.span)
        if unit.dimension is None:
            return nothing(node.span)
        value = to_si(node.value, unit.factor, unit.offset)
        return Typed(plan.Literal(value, node.span), quantity(unit.dimension))

    def _enum_value(self, node: ast.EnumValueReference, scope: Scope) -> Typed:
        assert node.enum is not None
        enum = self.program.find_type(scope.namespace, node.enum)
        if isinstance(enum, EnumSymbol):
            return self._member(enum, node.member.text, node.span)
        if enum is not None:
            self.bag.add(names.WrongKind(node.enum.span, node.enum.text, "no enumeration", "one with members"))
        elif not self.program.is_lenient:
            known = tuple(s.name for s in self.program.types.values() if isinstance(s, EnumSymbol))
            self.bag.add(names.UnknownType(node.enum.span, node.enum.text, known, "enumeration"))
        return nothing(node.span)

    def _member(self, enum: EnumSymbol, member: str, span: Span) -> Typed:
        if member in enum.members:
            return Typed(plan.Literal(enum_value(enum, member), span), Enumeration(enum))
        if not self.program.is_lenient:
            self.bag.add(names.UnknownMember(span, enum.name, member, tuple(enum.members)))
        return nothing(span)

    def _name(self, name: ast.Name, scope: Scope, expected: Type | None) -> Typed:
        if name.namespace is None and name.text in scope.bindings:
            return Typed(plan.Binding(name.text, name.span), scope.bindings[name.text])
        found = scope.fields.get(name.text)
        is_expected = isinstance(expected, Enumeration) and name.text in expected.symbol.members
        if isinstance(expected, Enumeration) and is_expected and (found is None or found.type != expected):
            return self._member(expected.symbol, name.text, name.span)
        if found is not None:
            return Typed(plan.Field(name.text, name.span), found.type)
        enums = self._enums_with(name, scope)
        if isinstance(expected, Enumeration) and len(enums) == 0:
            return self._unknown_name(name, scope, expected)
        if len(enums) == 1:
            return self._member(enums[0], name.text, name.span)
        if enums:
            self.bag.add(names.AmbiguousMember(name.span, name.text, tuple(enum.name for enum in enums)))
            return nothing(name.span)
        return self._unknown_name(name, scope, expected)

    def _enums_with(self, name: ast.Name, scope: Scope) -> list[EnumSymbol]:
        spaces = self.program.search(scope.namespace, name)
        return [enum for enum in self.program.holders.get(name.text, []) if enum.home.namespace in spaces]

    def is_open_member(self, node: ast.Expression, scope: Scope) -> bool:
        """Whether a name can only be a member of an enumeration, of which the other operand has to tell."""
        match node:
            case ast.NameExpression(name):
                is_field = name.text in scope.fields or name.text in scope.bindings
                return not is_field and bool(self._enums_with(name, scope))
            case ast.ListConstructor(items):
                return any(self.is_open_member(item, scope) for item in items)
            case _:
                return False

    def _unknown_name(self, name: ast.Name, scope: Scope, expected: Type | None) -> Typed:
        program = self.program
        is_hidden = program.is_lenient or (scope.owner is not None and is_open(scope.owner))
        if is_hidden or name.text in program.globals:
            return nothing(name.span)
        if isinstance(expected, Enumeration):
            self.bag.add(
                names.UnknownMember(name.span, expected.symbol.name, name.text, tuple(expected.symbol.members))
            )
            return nothing(name.span)
        symbol = program.find_type(scope.namespace, name)
        if symbol is not None:
            kind = "a unit's type" if isinstance(symbol, QuantitySymbol) else "a type"
            hint = f"`{name.text}(...)` constructs a value" if _is_struct(symbol) else ""
            self.bag.add(messages.NotAValue(name.span, name.text, kind, hint))
        elif scope.owner is not None and any(name.text in type_.methods for type_ in lineage(scope.owner)):
            self.bag.add(messages.NotAValue(name.span, name.text, "a method", f"call it: `{name.text}()`"))
        else:
            candidates = (*scope.fields, *scope.bindings, *program.holders)
            self.bag.add(names.UnknownName(name.span, name.text, candidates))
        return nothing(name.span)

    # ------------------------------------------------------------ postfix operators

    def _field_access(self, node: ast.FieldAccess, scope: Scope) -> Typed:
        base = self.value(node.base, scope)
        name = node.name
        match base.type:
            case Structured(symbol):
                fields = all_fields(symbol)
                owner = f"`{symbol.name}`"
            case EventObject(event):
                fields = event.parameters
                owner = f"event `{event.name}`"
            case _:
                if is_known(base.type):
                    self.bag.add(messages.NoFields(node.base.span, self.converter.describe(base.type)))
                return nothing(node.span)
        if name.text in fields:
            return Typed(plan.Member(base.expression, name.text, node.span), fields[name.text].type)
        if isinstance(base.type, Structured) and is_open(base.type.symbol):
            return nothing(node.span)
        if not self.program.is_lenient:
            self.bag.add(names.UnknownField(name.span, owner, name.text, tuple(fields)))
        return nothing(node.span)

    def _element(self, node: ast.ElementAccess, scope: Scope) -> Typed:
        base = self.value(node.base, scope)
        index = self.value(node.position, scope, INT)
        if is_known(index.type) and not is_integer(index.type):
            self.bag.add(messages.WrongIndex(node.position.span, self.converter.describe(index.type)))
        if isinstance(base.type, ListOf):
            return Typed(plan.Index(base.expression, index.expression, node.span), base.type.element)
        if is_known(base.type):
            self.bag.add(messages.NoElements(node.base.span, self.converter.describe(base.type)))
        return nothing(node.span)

    def _application(self, node: ast.FunctionApplication, scope: Scope) -> Typed:
        match node.function:
            case ast.NameExpression(name):
                symbol = self.program.find_type(scope.namespace, name)
                if isinstance(symbol, TypeSymbol) and symbol.kind is Kind.STRUCT:
                    if self.strict:
                        self.bag.add(messages.StructConstructor(node.span, name.text))
                    return self.values.from_arguments(symbol, node, scope)
                return self._call(None, name, node, scope)
            case ast.FieldAccess(base, name):
                return self._call(base, name, node, scope)
            case _:
                self.bag.add(messages.NotCallable(node.span, node.function.span.text))
                return nothing(node.span)

    def _call(
        self, base: ast.Expression | None, name: ast.Name, node: ast.FunctionApplication, scope: Scope
    ) -> Typed:
        """The call of a method: refused, if there is one of that name."""
        owner = scope.owner
        if isinstance(base, ast.NameExpression) and base.name.text not in scope.fields:
            named = self.program.find_type(scope.namespace, base.name)
            if isinstance(named, TypeSymbol) and base.name.text not in scope.bindings:
                return self._call_of(named, name, node)
        if base is not None:
            found = self.value(base, scope).type
            if not isinstance(found, Structured):
                return (
                    self.refuse(node.span, Construct.METHOD_CALL, name.text)
                    if is_known(found)
                    else nothing(node.span)
                )
            owner = found.symbol
        return self._call_of(owner, name, node)

    def _call_of(self, owner: TypeSymbol | None, name: ast.Name, node: ast.FunctionApplication) -> Typed:
        if owner is not None and any(name.text in type_.methods for type_ in lineage(owner)):
            return self.refuse(node.span, Construct.METHOD_CALL, name.text)
        if not (self.program.is_lenient or (owner is not None and is_open(owner))):
            hint = "scenarios and actions are invoked below `do`" if self._is_behavior(name) else ""
            known = tuple(method for type_ in lineage(owner) for method in type_.methods) if owner else ()
            what = "method"
            if isinstance(node.function, ast.NameExpression):
                what = "method or struct"
                known += tuple(symbol.name for symbol in self.program.types.values() if _is_struct(symbol))
            if hint:
                self.bag.add(messages.NotCallable(name.span, name.text, hint))
            else:
                self.bag.add(names.UnknownType(name.span, name.text, known, what))
        return nothing(node.span)

    def _is_behavior(self, name: ast.Name) -> bool:
        return any(key[2] == name.text for key in self.program.behaviors)

    # ------------------------------------------------------------ operators

    def _arithmetic(self, node: ast.Arithmetic, scope: Scope, expected: Type | None) -> Typed:
        """A chain of operators, from its left end: chains may be long, so they are no recursion."""
        chain: list[ast.Arithmetic] = [node]
        while isinstance(chain[-1].left, ast.Arithmetic):
            chain.append(chain[-1].left)
        if len(chain) > MAX_CHAIN:
            self.bag.add(syntax.TooDeep(node.span, MAX_CHAIN))
            return nothing(node.span)
        hint = expected if expected == UINT else None
        wants_int = expected is not None and is_number(expected) and expected != UINT
        first = chain[-1].left
        result = self.value(first, scope, hint)
        only_literals = isinstance(first, ast.IntegerLiteral)
        for step in reversed(chain):
            right = self.value(step.right, scope, hint)
            only_literals = only_literals and isinstance(step.right, ast.IntegerLiteral)
            result = self.operators.arithmetic(step, result, right, wants_int and only_literals)
        return result

    def _relations(self, node: ast.Relation, scope: Scope) -> Typed:
        chain: list[ast.Relation] = [node]
        while isinstance(chain[-1].left, ast.Relation):
            chain.append(chain[-1].left)
        if len(chain) > MAX_CHAIN:
            self.bag.add(syntax.TooDeep(node.span, MAX_CHAIN))
            return nothing(node.span)
        result: Typed | None = None
        for step in reversed(chain):
            left, right = self._operands(step, result, scope)
            result = self.operators.relation(step, left, right)
        assert result is not None
        return result

    def _operands(self, node: ast.Relation, left: Typed | None, scope: Scope) -> tuple[Typed, Typed]:
        """The operands of a relation; members of enumerations take their type from the other side."""
        is_in = node.operator == "in"
        is_right_open = self.is_open_member(node.right, scope)
        if left is None and not is_right_open and self.is_open_member(node.left, scope):
            right = self.value(node.right, scope)
            hint = right.type.element if is_in and isinstance(right.type, ListOf) else right.type
            return self.value(node.left, scope, hint), right
        if left is None:
            left = self.value(node.left, scope)
        wanted = ListOf(left.type) if is_in and isinstance(node.right, ast.ListConstructor) else left.type
        return left, self.value(node.right, scope, wanted if is_right_open else None)

    def _logic(self, node: ast.Logic, scope: Scope) -> Typed:
        chain: list[ast.Logic] = [node]
        while isinstance(chain[-1].left, ast.Logic):
            chain.append(chain[-1].left)
        if len(chain) > MAX_CHAIN:
            self.bag.add(syntax.TooDeep(node.span, MAX_CHAIN))
            return nothing(node.span)
        result = self.value(chain[-1].left, scope, BOOL)
        for step in reversed(chain):
            left = self.operators.truth(result, step.operator, step.left.span)
            right = self.operators.truth(self.value(step.right, scope, BOOL), step.operator, step.right.span)
            result = Typed(plan.Logic(step.operator, left, right, step.span), BOOL)
        return result


def _integer_type(value: int, expected: Type | None) -> Type:
    if value < 0:
        return INT
    return INT if expected in (INT, FLOAT) and value < 2**63 else UINT


def _signed(expected: Type | None) -> Type | None:
    return INT if expected == UINT else expected


def _is_struct(symbol: QuantitySymbol | EnumSymbol | TypeSymbol) -> bool:
    return isinstance(symbol, TypeSymbol) and symbol.kind is Kind.STRUCT
