"""From the parser's reductions to the tree: names, types, arguments and expressions. `build.py` has the rest."""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import syntax
from seoro.lang.lexer import Number, Token
from seoro.lang.source import SourceFile, Span


class ExpressionBuilder:
    """Makes the nodes of expressions.

    Args:
        file: The file.
        bag: Where messages go.
    """

    def __init__(self, file: SourceFile, bag: Bag) -> None:
        self._file = file
        self._bag = bag

    # ------------------------------------------------------------ names

    def identifier(self, span: Span, token: Token) -> ast.Name:
        """A name without prefix."""
        return ast.Name(bare(token.value), None, span)

    def prefixed_identifier(self, span: Span, token: Token) -> ast.Name:
        """A name with its namespace."""
        return _name(token.value, span)

    def qualified_behavior_name(self, span: Span, actor: ast.Name | None, name: ast.Name) -> ast.BehaviorName:
        """`[actor.]name`."""
        return ast.BehaviorName(actor, name, span)

    def primitive_type(self, span: Span, word: Token) -> ast.PrimitiveTypeName:
        """A built-in type."""
        return ast.PrimitiveTypeName(word.value, span)

    def named_type(self, span: Span, name: ast.BehaviorName) -> ast.NamedType:
        """A declared type."""
        return ast.NamedType(name, span)

    def list_type_declarator(self, span: Span, element: ast.TypeDeclarator) -> ast.ListTypeDeclarator:
        """`list of ...`."""
        return ast.ListTypeDeclarator(element, span)

    def range_type_declarator(self, span: Span, element: ast.TypeDeclarator) -> ast.RangeTypeDeclarator:
        """`range of ...`."""
        return ast.RangeTypeDeclarator(element, span)

    # ------------------------------------------------------------ 7.2.2.5 arguments

    def argument_list_specification(
        self, span: Span, *arguments: ast.ArgumentSpecification
    ) -> tuple[ast.ArgumentSpecification, ...]:
        """Parameters of an event or a method."""
        return arguments

    def argument_specification(
        self, span: Span, name: ast.Name, type_: ast.TypeDeclarator, default: ast.Expression | None
    ) -> ast.ArgumentSpecification:
        """A parameter of an event or a method."""
        return ast.ArgumentSpecification(name, type_, default, span)

    def argument_list(self, span: Span, *arguments: ast.Expression | ast.NamedArgument) -> ast.ArgumentList:
        """Arguments: positional ones first."""
        positional: list[ast.Expression] = []
        named: list[ast.NamedArgument] = []
        for argument in arguments:
            if isinstance(argument, ast.NamedArgument):
                named.append(argument)
            else:
                if named:
                    self._bag.add(syntax.MixedArguments(argument.span))
                positional.append(argument)
        return ast.ArgumentList(tuple(positional), tuple(named), span)

    def positional_argument(self, span: Span, value: ast.Expression) -> ast.Expression:
        """An argument without name."""
        return value

    def named_argument(self, span: Span, name: ast.Name, value: ast.Expression) -> ast.NamedArgument:
        """`name: value`."""
        return ast.NamedArgument(name, value, span)

    # ------------------------------------------------------------ 7.2.2.6 expressions

    def ternary_op_exp(
        self, span: Span, condition: ast.Expression, then: ast.Expression, otherwise: ast.Expression
    ) -> ast.TernaryOpExp:
        """`c ? a : b`."""
        return ast.TernaryOpExp(condition, then, otherwise, span)

    def implication(self, span: Span, left: ast.Expression, right: ast.Expression) -> ast.Logic:
        """`a => b`."""
        return ast.Logic("=>", left, right, span)

    def disjunction(self, span: Span, left: ast.Expression, right: ast.Expression) -> ast.Logic:
        """`a or b`."""
        return ast.Logic("or", left, right, span)

    def conjunction(self, span: Span, left: ast.Expression, right: ast.Expression) -> ast.Logic:
        """`a and b`."""
        return ast.Logic("and", left, right, span)

    def inversion(self, span: Span, operand: ast.Expression) -> ast.Inversion:
        """`not a`."""
        return ast.Inversion(operand, span)

    def relation(self, span: Span, left: ast.Expression, operator: str, right: ast.Expression) -> ast.Relation:
        """`a < b`."""
        return ast.Relation(operator, left, right, span)

    def relational_op(self, span: Span, word: Token) -> str:
        """A relational operator."""
        return str(word.value)

    def sum(self, span: Span, left: ast.Expression, operator: str, right: ast.Expression) -> ast.Arithmetic:
        """`a + b`."""
        return ast.Arithmetic(operator, left, right, span)

    def additive_op(self, span: Span, word: Token) -> str:
        """`+` or `-`."""
        return str(word.value)

    def term(self, span: Span, left: ast.Expression, operator: str, right: ast.Expression) -> ast.Arithmetic:
        """`a * b`."""
        return ast.Arithmetic(operator, left, right, span)

    def multiplicative_op(self, span: Span, word: Token) -> str:
        """`*`, `/` or `%`."""
        return str(word.value)

    def negation(self, span: Span, operand: ast.Expression) -> ast.Expression:
        """`-a`; a sign directly before a number belongs to it."""
        if operand.span.start == span.start + 1:
            match operand:
                case ast.IntegerLiteral(value) if value >= 0 and not operand.span.text.startswith("0x"):
                    if value > 2**63:
                        self._bag.add(syntax.IntegerOutOfRange(span))
                        value = 0
                    return ast.IntegerLiteral(-value, span)
                case ast.FloatLiteral(value) if operand.span.text[0] not in "+-":
                    return ast.FloatLiteral(-value, span)
                case ast.PhysicalLiteral(value, unit) if operand.span.text[0] not in "+-":
                    return ast.PhysicalLiteral(-value, unit, span)
        return ast.Negation(operand, span)

    def positive_literal(
        self, span: Span, literal: ast.FloatLiteral | ast.PhysicalLiteral
    ) -> ast.FloatLiteral | ast.PhysicalLiteral:
        """`+1.5`: the sign belongs to the number."""
        if literal.span.start != span.start + 1:
            self._bag.add(syntax.UnexpectedToken(span, "`+`", ("an expression",)))
        if isinstance(literal, ast.FloatLiteral):
            return ast.FloatLiteral(literal.value, span)
        return ast.PhysicalLiteral(literal.value, literal.unit, span)

    def cast_exp(self, span: Span, base: ast.Expression, type_: ast.TypeDeclarator) -> ast.CastExp:
        """`a.as(T)`."""
        return ast.CastExp(base, type_, span)

    def type_test_exp(self, span: Span, base: ast.Expression, type_: ast.TypeDeclarator) -> ast.TypeTestExp:
        """`a.is(T)`."""
        return ast.TypeTestExp(base, type_, span)

    def element_access(self, span: Span, base: ast.Expression, index: ast.Expression) -> ast.ElementAccess:
        """`a[i]`."""
        return ast.ElementAccess(base, index, span)

    def function_application(
        self, span: Span, function: ast.Expression, arguments: ast.ArgumentList | None
    ) -> ast.FunctionApplication:
        """`f(...)`."""
        return ast.FunctionApplication(function, arguments or ast.ArgumentList((), (), span), span)

    def field_access(self, span: Span, base: ast.Expression, name: ast.Name) -> ast.FieldAccess:
        """`a.b`."""
        return ast.FieldAccess(base, name, span)

    def it(self, span: Span) -> ast.It:
        """`it`."""
        return ast.It(span)

    def name_expression(self, span: Span, name: ast.Name) -> ast.NameExpression:
        """A name."""
        return ast.NameExpression(name, span)

    def integer_literal(self, span: Span, digits: Token) -> ast.IntegerLiteral:
        """A whole number."""
        number: Number = digits.value
        return ast.IntegerLiteral(int(number.value), span)

    def float_literal(self, span: Span, word: Token) -> ast.FloatLiteral:
        """A number with a fraction or an exponent, `inf` or `nan`."""
        value = word.value
        return ast.FloatLiteral(float(value.value if isinstance(value, Number) else value), span)

    def physical_literal(self, span: Span, digits: Token) -> ast.PhysicalLiteral:
        """A number with its unit."""
        number: Number = digits.value
        assert number.unit is not None
        start = span.end - len(number.unit)
        return ast.PhysicalLiteral(number.value, _name(number.unit, Span(self._file, start, span.end)), span)

    def bool_literal(self, span: Span, word: Token) -> ast.BoolLiteral:
        """`true` or `false`."""
        return ast.BoolLiteral(word.value == "true", span)

    def string_literal(self, span: Span, text: Token) -> ast.StringLiteral:
        """A string."""
        return ast.StringLiteral(text.value, span)

    def enum_value(self, span: Span, enum: ast.Name, member: ast.Name) -> ast.EnumValueReference:
        """`enum!member`."""
        return ast.EnumValueReference(enum, member, span)

    def list_constructor(self, span: Span, *items: ast.Expression) -> ast.ListConstructor:
        """`[a, b]`."""
        return ast.ListConstructor(items, span)

    def range_constructor(self, span: Span, low: ast.Expression, high: ast.Expression) -> ast.RangeConstructor:
        """`[a..b]` or `range(a, b)`."""
        return ast.RangeConstructor(low, high, span)


def bare(text: str) -> str:
    """An identifier without its bars."""
    return text[1:-1] if text.startswith("|") else text


def _name(text: str, span: Span) -> ast.Name:
    """A name that may have a prefix; bars may contain `::`."""
    if not text.startswith("|") and "::" in text:
        namespace, _, rest = text.partition("::")
    elif "|::" in text:
        namespace, _, rest = text.partition("|::")
        namespace = namespace[1:]
    else:
        return ast.Name(bare(text), None, span)
    return ast.Name(bare(rest), namespace or "null", span)
