"""Fourth pass: expressions get their types and become expressions of the plan (7.4).

`expected` is a hint, not a demand: it decides between members of several enumerations with one name, gives the
elements of a list their type, and says whether an integer literal is meant as `int`. Whether the value fits its
place is for `Converter.convert`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import assert_never

from seoro.lang import ast, plan
from seoro.lang.check.aggregates import Aggregates
from seoro.lang.check.applications import Applications
from seoro.lang.check.arguments import NO_TRAITS, Traits
from seoro.lang.check.calls import Calls
from seoro.lang.check.casts import Casts
from seoro.lang.check.compositions import ANY_BEHAVIOR, OVERLAP_KIND
from seoro.lang.check.constraints import Constraints
from seoro.lang.check.convert import Converter, Typed, nothing
from seoro.lang.check.holders import Holders, implicit_duration
from seoro.lang.check.labels import Labels
from seoro.lang.check.lookup import Lookup, candidates
from seoro.lang.check.methods import Methods
from seoro.lang.check.operators import Operators
from seoro.lang.check.plan_types import enum_value
from seoro.lang.check.resolve import Resolver
from seoro.lang.check.values import Values
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import methods as method_messages
from seoro.lang.diagnostics import names, syntax
from seoro.lang.diagnostics import types as messages
from seoro.lang.members import MemberTable
from seoro.lang.recorder import EnumMember
from seoro.lang.source import Span
from seoro.lang.symbols import (
    EnumSymbol,
    FieldSymbol,
    Home,
    Kind,
    Program,
    QuantitySymbol,
    Space,
    TypeSymbol,
    all_fields,
    is_open,
)
from seoro.lang.traits import ParameterTrait
from seoro.lang.types import (
    BOOL,
    FLOAT,
    INT,
    STRING,
    UINT,
    UNKNOWN,
    CompositionObject,
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
MAX_CHAIN = 20_000  # of operands in a row


@dataclass(frozen=True)
class Scope:
    """What names mean where an expression stands.

    Args:
        owner: The type whose fields can be named; None if there is none.
        space: The scope of the text's namespace statement.
        bindings: `actor`, the event objects of `as` clauses, and parameters of a method.
        fields: The fields that can be named.
        it: The type of `it`; None if it stands for nothing.
        is_it_bound: Whether `it` is a binding.
        it_value: What `it` stands for if it is no binding; None for the instance itself.
        labels: The labels that stand for what was invoked under them; None before anything runs.
    """

    owner: TypeSymbol | None
    space: Space
    bindings: Mapping[str, Type] = field(default_factory=dict)
    fields: MemberTable[FieldSymbol] = field(default_factory=MemberTable)
    it: Type | None = None
    is_it_bound: bool = False
    it_value: plan.Expression | None = None
    labels: Labels | None = None


def scope_of(owner: TypeSymbol | None, home: Home) -> Scope:
    """The scope of the members of a type, in its declaration or an extension; of None, of global parameters."""
    if owner is None:
        return Scope(None, home.space)
    bindings: dict[str, Type] = {"actor": Structured(owner.actor)} if owner.actor is not None else {}
    if owner.kind is Kind.MODIFIER:
        return Scope(owner, home.space, bindings, all_fields(owner), _modified(owner), is_it_bound=True)
    return Scope(owner, home.space, bindings, all_fields(owner), Structured(owner))


def _modified(modifier: TypeSymbol) -> Type:
    """The type of `it` in a modifier: of what it modifies (7.4.1.3)."""
    if modifier.of is not None:
        return Structured(modifier.of)
    return UNKNOWN if is_open(modifier) else ANY_BEHAVIOR


def running_scope(owner: TypeSymbol, home: Home, labels: Labels) -> Scope:
    """The scope of the members of a type that are evaluated while an instance of it runs."""
    return replace(scope_of(owner, home), labels=labels)


class Expressions:
    """Elaborates expressions.

    Args:
        program: The program.
        bag: Where messages go.
        strict: Whether to report extensions to the standard.
        traits: What the Python implementations of actions and modifiers take.
    """

    def __init__(self, program: Program, bag: Bag, strict: bool, traits: Traits = NO_TRAITS) -> None:
        self.program = program
        self.bag = bag
        self.lookup = Lookup(program, bag)
        self._resolver = Resolver(program, bag)
        self.converter = Converter(program, bag, strict)
        self.operators = Operators(program, self.converter, bag, strict)
        self.values = Values(self)
        self.constraints = Constraints(self)
        self.aggregates = Aggregates(self)
        self.methods = Methods(self)
        self.calls = Calls(self)
        self.casts = Casts(self)
        self.holders = Holders(self)
        self.applications = Applications()
        self.strict = strict
        self._traits = traits
        self._depth = 0

    def converted(self, node: ast.Expression, target: Type, scope: Scope, context: str = "") -> plan.Expression:
        """An expression as a value of a type."""
        return self.converter.convert(self.value(node, scope, target), target, context)

    def value(self, node: ast.Expression, scope: Scope, expected: Type | None = None) -> Typed:
        """An expression with its type."""
        if self._depth >= MAX_DEPTH:
            self.bag.add(syntax.TooDeep(node.span, MAX_DEPTH))
            return nothing(node.span)
        self._depth += 1
        try:
            found = self._value(node, scope, expected)
            if self.program.recorder is not None:
                self.program.recorder.value(node.span, found.type)
            return found
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
                return self._it(span, scope)
            case ast.CastExp():
                return self.casts.cast(node, scope)
            case ast.TypeTestExp():
                return self.casts.test(node, scope)
            case _:
                assert_never(node)

    def type_of(self, declarator: ast.TypeDeclarator, space: Space) -> Type:
        """The type that a declarator means."""
        return self._resolver.type_of(declarator, space)

    def traits_of(self, symbol: TypeSymbol) -> Mapping[str, ParameterTrait]:
        """What the Python implementation of an action or a modifier takes for parameters."""
        return self._traits.get((symbol.kind, symbol.plan_name), {})

    # ------------------------------------------------------------ literals and names

    def _physical(self, node: ast.PhysicalLiteral) -> Typed:
        unit = self.program.units.get(node.unit.text)
        if unit is None:
            if not self.program.is_lenient:
                self.bag.add(names.UnknownUnit(node.unit.span, node.unit.text, tuple(self.program.units)))
            return nothing(node.span)
        if self.program.recorder is not None:
            self.program.recorder.name(node.unit.span, unit)
        if unit.dimension is None:
            return nothing(node.span)
        value = to_si(node.value, unit.factor, unit.offset)
        return Typed(plan.Literal(value, node.span), quantity(unit.dimension))

    def _enum_value(self, node: ast.EnumValueReference, scope: Scope) -> Typed:
        assert node.enum is not None
        enum = self.lookup.type(scope.space, node.enum)
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
            if self.program.recorder is not None:
                self.program.recorder.name(span, EnumMember(enum, member))
            return Typed(plan.Literal(enum_value(enum, member), span), Enumeration(enum))
        if not self.program.is_lenient:
            self.bag.add(names.UnknownMember(span, enum.name, member, tuple(enum.members)))
        return nothing(span)

    def _name(self, name: ast.Name, scope: Scope, expected: Type | None) -> Typed:
        if name.namespace is None and name.text in scope.bindings:
            return Typed(plan.Binding(name.text, name.span), scope.bindings[name.text])
        if expected == OVERLAP_KIND and name.namespace is None and name.text in OVERLAP_KIND.symbol.members:
            return Typed(plan.Literal(enum_value(OVERLAP_KIND.symbol, name.text), name.span), OVERLAP_KIND)
        found = self.lookup.member(scope.space, scope.fields, name)
        enum = expected.symbol if isinstance(expected, Enumeration) else None
        is_other = found is None or found.type != expected
        if enum is not None and is_other and self.lookup.is_member(scope.space, enum, name):
            return self._member(enum, name.text, name.span)
        if found is not None:
            return Typed(plan.Field(found.name, name.span), found.type)
        parameter = self.lookup.global_parameter(scope.space, name)
        if parameter is not None:
            return Typed(plan.Global(parameter.name, name.span), parameter.type)
        enums = self.lookup.enumerations(scope.space, name)
        if len(enums) == 1:
            return self._member(enums[0], name.text, name.span)
        if enums:
            self.bag.add(names.AmbiguousMember(name.span, name.text, tuple(enum.name for enum in enums)))
            return nothing(name.span)
        return self._unknown_name(name, scope, expected)

    def is_open_member(self, node: ast.Expression, scope: Scope) -> bool:
        """Whether a name can only be a member of an enumeration, of which the other operand has to tell."""
        match node:
            case ast.NameExpression(name):
                is_bound = name.namespace is None and name.text in scope.bindings
                is_field = self.lookup.member(scope.space, scope.fields, name) is not None
                return not is_bound and not is_field and bool(self.lookup.enumerations(scope.space, name))
            case ast.ListConstructor(items):
                return any(self.is_open_member(item, scope) for item in items)
            case _:
                return False

    def _it(self, span: Span, scope: Scope) -> Typed:
        if scope.it is None:
            self.bag.add(method_messages.NoIt(span))
            return nothing(span)
        if scope.is_it_bound:
            return Typed(plan.Binding("it", span), scope.it)
        if scope.it_value is not None:
            return Typed(replace(scope.it_value, span=span), scope.it)
        return Typed(plan.Self(span), scope.it)

    def _unknown_name(self, name: ast.Name, scope: Scope, expected: Type | None) -> Typed:
        program = self.program
        if program.is_lenient or (scope.owner is not None and is_open(scope.owner)):
            return nothing(name.span)
        if isinstance(expected, Enumeration):
            self.bag.add(
                names.UnknownMember(name.span, expected.symbol.name, name.text, tuple(expected.symbol.members))
            )
            return nothing(name.span)
        symbol = self.lookup.type(scope.space, name)
        if symbol is not None:
            kind = "a unit's type" if isinstance(symbol, QuantitySymbol) else "a type"
            hint = f"`{name.text}(...)` constructs a value" if _is_struct(symbol) else ""
            self.bag.add(messages.NotAValue(name.span, name.text, kind, hint))
        elif self.methods.own(name, scope) is not None:
            self.bag.add(messages.NotAValue(name.span, name.text, "a method", f"call it: `{name.text}()`"))
        elif scope.owner is not None and name.text in (labels := Labels(scope.owner, self)):
            is_early, is_invocation = scope.labels is None, labels.is_invocation(name.text)
            self.bag.add(messages.LabelAsValue(name.span, name.text, is_invocation, is_early))
        else:
            members = candidates((*scope.fields.values(), *program.globals.values()), name)
            known = (*members, *scope.bindings, *program.holders)
            self.bag.add(names.UnknownName(name.span, name.text, known))
        return nothing(name.span)

    # ------------------------------------------------------------ postfix operators

    def _field_access(self, node: ast.FieldAccess, scope: Scope) -> Typed:
        base = self.holders.find(node.base, scope)
        name = node.name
        match base.type:
            case Structured(symbol):
                fields = all_fields(symbol)
                owner = f"`{symbol.name}`"
            case EventObject(event):
                fields = event.parameters
                owner = f"event `{event.name}`"
            case CompositionObject(composition):
                fields = composition.parameters
                owner = f"`{composition.name}`"
            case _:
                if is_known(base.type):
                    self.bag.add(messages.NoFields(node.base.span, self.converter.describe(base.type)))
                return nothing(node.span)
        found = self._member_field(base.type, fields, name, scope) or implicit_duration(base, name)
        if found is not None:
            if isinstance(base.expression, plan.Self):
                return Typed(plan.Field(found.name, node.span), found.type)
            return Typed(plan.Member(base.expression, found.name, node.span), found.type)
        if isinstance(base.type, Structured) and is_open(base.type.symbol):
            return nothing(node.span)
        if not self.program.is_lenient:
            is_composition = isinstance(base.type, CompositionObject)
            known = tuple(fields) if is_composition else candidates(fields.values(), name)
            hint = "to use those of a scenario or an action, say so by `of`" if base.type == ANY_BEHAVIOR else ""
            self.bag.add(names.UnknownField(name.span, owner, name.text, known, hint))
        return nothing(node.span)

    def _member_field(
        self, type_: Type, fields: MemberTable[FieldSymbol], name: ast.Name, scope: Scope
    ) -> FieldSymbol | None:
        """The field that a name means; parameters of events need no prefix, those of compositions have none."""
        if not isinstance(type_, CompositionObject):
            find = self.lookup.parameter if isinstance(type_, EventObject) else self.lookup.member
            return find(scope.space, fields, name)
        found = fields.get(name.text) if name.namespace is None else None
        if found is not None and type_ == ANY_BEHAVIOR and scope.owner is not None:
            self.applications.use(scope.owner, found.name, name.span)
        return found

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
        is_hinted = is_right_open or left.type == OVERLAP_KIND
        return left, self.value(node.right, scope, wanted if is_hinted else None)

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
