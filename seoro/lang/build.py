"""Builder of the tree: one callback per production that has a node.

`automaton.py` calls them with the span of the production and the children that the grammar keeps; an absent
optional part is `None`. Most productions have a node class of their name, whose fields are these children.
Methods build the others, and check rules of the standard that the grammar cannot express: the order of arguments,
and the ranges of numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Final, TypeAlias

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import syntax
from seoro.lang.lexer import Number, Token
from seoro.lang.source import SourceFile, Span

Callback: TypeAlias = Callable[..., Any]


class Builder:
    """Builds the nodes of one file.

    Args:
        file: The file.
        bag: Bag for messages.
    """

    def __init__(self, file: SourceFile, bag: Bag) -> None:
        self._file = file
        self._bag = bag

    # ------------------------------------------------------------ 7.2.2.1 top level

    def osc_file(self, span: Span, *statements: ast.Statement) -> ast.OscFile:
        """Build the file; imports come first."""
        is_prelude = True
        for statement in statements:
            if isinstance(statement, ast.ImportModule | ast.ImportUri):
                if not is_prelude:
                    self._bag.add(syntax.late_import, statement.span)
            elif not isinstance(statement, ast.InvalidStatement):
                is_prelude = False
        return ast.OscFile(statements, (), span)

    def invalid_statement(self, span: Span, token: Token) -> ast.InvalidStatement:
        """Build the replacement of an unparsable statement."""
        return ast.InvalidStatement(span)

    def invalid_member(self, span: Span, token: Token) -> ast.DoMember:
        """Build the replacement of an unparsable behavior."""
        return ast.DoMember(None, ast.InvalidStatement(span), span)

    def import_statement(self, span: Span, reference: ast.ImportUri | list[str]) -> ast.ImportStatement:
        """`import ...`."""
        return ast.ImportModule(tuple(reference), span) if isinstance(reference, list) else reference

    def structured_identifier(self, span: Span, *names: Token) -> list[str]:
        """`a.b.c`."""
        return [bare(name.value) for name in names]

    def namespace_statement(self, span: Span, name: str, uses: tuple[str, ...] | None) -> ast.NamespaceStatement:
        """`namespace ...`."""
        return ast.NamespaceStatement(name, uses or (), span)

    def namespace_name(self, span: Span, name: Token) -> str:
        """Return the name of a namespace."""
        return bare(name.value)

    def export_wildcard_specification(self, span: Span, prefix: Token | None = None) -> ast.ExportWildcard:
        """`*`, with or without a namespace."""
        if prefix is None or "::" not in prefix.value:
            return ast.ExportWildcard(None, span)
        return ast.ExportWildcard(bare(prefix.value.partition("::")[0]) or "null", span)

    # ------------------------------------------------------------ 7.2.2.2 types

    def unit_declaration(
        self,
        span: Span,
        name: ast.Name,
        quantity: ast.Name,
        specifier: tuple[tuple[ast.SiBaseExponent, ...], float, float],
    ) -> ast.UnitDeclaration:
        """`unit ...`."""
        return ast.UnitDeclaration(name, quantity, *specifier, span)

    def unit_specifier(self, span: Span, *parts: Any) -> tuple[tuple[ast.SiBaseExponent, ...], float, float]:
        """`SI(...)` of a unit; the factor is 1 and the offset 0 unless given."""
        *exponents, factor, offset = parts
        return tuple(exponents), 1.0 if factor is None else factor, 0.0 if offset is None else offset

    def si_base_exponent(self, span: Span, unit: Token, exponent: int) -> ast.SiBaseExponent:
        """`m: 1`."""
        return ast.SiBaseExponent(bare(unit.value), exponent, span)

    def signed_integer(self, span: Span, sign: Token | None, digits: Token) -> int:
        """Return the value of an integer."""
        number: Number = digits.value
        return -int(number.value) if sign is not None else int(number.value)

    def signed_number(self, span: Span, sign: Token | None, digits: Token) -> float:
        """Return the value of a number."""
        number: Number = digits.value
        return -float(number.value) if sign is not None and sign.kind == "MINUS" else float(number.value)

    def enum_number(self, span: Span, digits: Token) -> int:
        """Return the number of a member."""
        number: Number = digits.value
        return int(number.value)

    def structured_type_extension(self, span: Span, *parts: Any) -> ast.StructuredTypeExtension:
        """`extend <type>: ...`; the type's name is one name or two."""
        names = [part for part in parts if isinstance(part, ast.Name)]
        actor = names[0] if len(names) == 2 else None
        name = ast.BehaviorName(actor, names[-1], names[0].span.to(names[-1].span))
        return ast.StructuredTypeExtension(name, tuple(parts[len(names) :]), span)

    # ------------------------------------------------------------ 7.2.2.4 members

    def event_declaration(
        self,
        span: Span,
        name: ast.Name,
        parameters: tuple[ast.ArgumentSpecification, ...] | None,
        specification: ast.EventSpecification | None,
    ) -> ast.EventDeclaration:
        """`event ...`."""
        return ast.EventDeclaration(name, parameters or (), specification, span)

    def bool_condition(self, span: Span, condition: ast.Expression) -> ast.BoolCondition:
        """Build a condition; its span excludes brackets around it."""
        return ast.BoolCondition(condition, condition.span)

    def parameter_declaration(
        self,
        span: Span,
        names: tuple[ast.Name, ...],
        type_: ast.TypeDeclarator,
        default: ast.Expression | None,
        members: tuple[Any, ...] = (),
    ) -> ast.ParameterDeclaration:
        """Build a parameter, or several of one type."""
        coverage = tuple(member for member in members if isinstance(member, ast.CoverageDeclaration))
        constraints = tuple(member for member in members if not isinstance(member, ast.CoverageDeclaration))
        return ast.ParameterDeclaration(names, type_, default, constraints, coverage, span)

    def method_declaration(
        self,
        span: Span,
        name: ast.Name,
        parameters: tuple[ast.ArgumentSpecification, ...] | None,
        result: ast.TypeDeclarator | None,
        qualifier: str | None,
        implementation: Any,
    ) -> ast.MethodDeclaration:
        """`def ...`."""
        return ast.MethodDeclaration(name, parameters or (), result, bool(qualifier), implementation, span)

    def external_method(
        self, span: Span, path: list[str], arguments: ast.ArgumentList | None
    ) -> ast.ExternalMethod:
        """`external ...`."""
        return ast.ExternalMethod(tuple(path), arguments or ast.ArgumentList((), (), span), span)

    def composition(
        self, span: Span, operator: str, arguments: ast.ArgumentList | None, *rest: Any
    ) -> ast.Composition:
        """`serial: ...` and its like."""
        *members, modifications = rest
        return ast.Composition(operator, arguments, tuple(members), modifications, span)

    def behavior_invocation(
        self, span: Span, invocation: ast.FunctionApplication, modifications: ast.WithBlock | None = None
    ) -> ast.BehaviorInvocation:
        """Build an invocation with or without a `with:` block."""
        return ast.BehaviorInvocation(invocation, modifications, span)

    # ------------------------------------------------------------ 7.2.2.5 names and arguments

    def identifier(self, span: Span, token: Token) -> ast.Name:
        """Build a name without prefix."""
        return ast.Name(bare(token.value), None, span)

    def prefixed_identifier(self, span: Span, token: Token) -> ast.Name:
        """Build a name with its namespace."""
        return _name(token.value, span)

    def argument_list(self, span: Span, *arguments: ast.Expression | ast.NamedArgument) -> ast.ArgumentList:
        """Build arguments; positional ones come first."""
        positional: list[ast.Expression] = []
        named: list[ast.NamedArgument] = []
        for argument in arguments:
            if isinstance(argument, ast.NamedArgument):
                named.append(argument)
            else:
                if named:
                    self._bag.add(syntax.mixed_arguments, argument.span)
                positional.append(argument)
        return ast.ArgumentList(tuple(positional), tuple(named), span)

    # ------------------------------------------------------------ 7.2.2.6 expressions

    def negation(self, span: Span, operand: ast.Expression) -> ast.Expression:
        """`-a`; a sign directly before a number belongs to it."""
        if operand.span.start == span.start + 1:
            match operand:
                case ast.IntegerLiteral(value) if value >= 0 and not operand.span.text.startswith("0x"):
                    if value > 2**63:
                        self._bag.add(syntax.integer_out_of_range, span)
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
            self._bag.add(syntax.unexpected_token, span, "`+`", ("an expression",))
        if isinstance(literal, ast.FloatLiteral):
            return ast.FloatLiteral(literal.value, span)
        return ast.PhysicalLiteral(literal.value, literal.unit, span)

    def function_application(
        self, span: Span, function: ast.Expression, arguments: ast.ArgumentList | None
    ) -> ast.FunctionApplication:
        """`f(...)`."""
        return ast.FunctionApplication(function, arguments or ast.ArgumentList((), (), span), span)

    def integer_literal(self, span: Span, digits: Token) -> ast.IntegerLiteral:
        """Build an integer."""
        number: Number = digits.value
        return ast.IntegerLiteral(int(number.value), span)

    def float_literal(self, span: Span, word: Token) -> ast.FloatLiteral:
        """Build a number with a fraction or an exponent, `inf` or `nan`."""
        value = word.value
        return ast.FloatLiteral(float(value.value if isinstance(value, Number) else value), span)

    def physical_literal(self, span: Span, digits: Token) -> ast.PhysicalLiteral:
        """Build a number with its unit."""
        number: Number = digits.value
        assert number.unit is not None
        start = span.end - len(number.unit)
        return ast.PhysicalLiteral(number.value, _name(number.unit, Span(self._file, start, span.end)), span)

    def bool_literal(self, span: Span, word: Token) -> ast.BoolLiteral:
        """`true` or `false`."""
        return ast.BoolLiteral(word.value == "true", span)


def bare(text: str) -> str:
    """Remove the bars of an identifier."""
    return text[1:-1] if text.startswith("|") else text


def _name(text: str, span: Span) -> ast.Name:
    """Create a name with an optional prefix; bars may contain `::`."""
    if not text.startswith("|") and "::" in text:
        namespace, _, rest = text.partition("::")
    elif "|::" in text:
        namespace, _, rest = text.partition("|::")
        namespace = namespace[1:]
    else:
        return ast.Name(bare(text), None, span)
    return ast.Name(bare(rest), namespace or "null", span)


# ---------------------------------------------------------------- productions without a method

_CLASSES: Final[Mapping[str, type[ast.Node]]] = {
    "qualified_behavior_name": ast.BehaviorName,
    "keep_constraint_declaration": ast.KeepConstraint,
    "remove_default_declaration": ast.RemoveDefault,
    "behavior_with_declaration": ast.WithBlock,
    "enum_value": ast.EnumValueReference,
    "primitive_type": ast.PrimitiveTypeName,
}  # node classes that are not named after their productions
_WITH_ITEMS: Final = frozenset(
    {ast.ExportStatement, ast.OnDirective, ast.WithBlock, ast.ListConstructor, ast.PrimitiveTypeExtension}
    | {ast.StructDeclaration, ast.ActorDeclaration, ast.ScenarioDeclaration, ast.ActionDeclaration}
    | {ast.ModifierDeclaration}
)  # nodes whose last field contains all remaining children
_ITEMS: Final = frozenset(
    {"namespace_list", "base_unit_specifier", "enum_members", "field_names", "parameter_with_declaration"}
    | {"argument_list_specification", "inheritance_condition"}
)  # productions that stand for the tuple of their children
_WORDS: Final = frozenset(
    {"constraint_qualifier", "method_qualifier", "coverage_kind", "composition_operator"}
    | {"relational_op", "additive_op", "multiplicative_op"}
)  # productions that stand for a word or a sign
# Nodes whose only field is the value of a token.
_OF_TOKENS: Final = frozenset({ast.ImportUri, ast.PrimitiveTypeName, ast.StringLiteral})
_LOGIC: Final = {"implication": "=>", "disjunction": "or", "conjunction": "and"}
_BINARY: Final = {"relation": ast.Relation, "sum": ast.Arithmetic, "term": ast.Arithmetic}  # with the sign between


@cache
def callback_of(production: str) -> Callback:
    """Return the function that builds the node of a production, from a builder, the span and the children."""
    own: Callback | None = getattr(Builder, production, None)
    if own is not None:
        return own
    if production in _ITEMS:
        return lambda _, span, *children: children
    if production in _WORDS:
        return lambda _, span, token: str(token.value)
    if production in _LOGIC:
        sign = _LOGIC[production]
        return lambda _, span, left, right: ast.Logic(sign, left, right, span)
    if production in _BINARY:
        operation = _BINARY[production]
        return lambda _, span, left, operator, right: operation(operator, left, right, span)
    cls: Any = _CLASSES.get(production) or getattr(ast, production.title().replace("_", ""))
    if cls in _OF_TOKENS:
        return lambda _, span, token: cls(token.value, span)
    count = len(cls.__match_args__) - 2 if cls in _WITH_ITEMS else None

    def node(_: Builder, span: Span, *children: Any) -> Any:
        return cls(*children, span) if count is None else cls(*children[:count], children[count:], span)

    return node
