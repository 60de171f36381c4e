"""From the parser's reductions to the tree: one method for each production that has a node.

The methods are called by `parser.py` with the production's span and those children that the grammar keeps; an
absent optional part is None. What the grammar leaves open and the standard does not (the order of arguments,
the ranges of numbers) is checked here.
"""

from __future__ import annotations

from typing import Any

from seoro.lang import ast
from seoro.lang.build_expressions import bare
from seoro.lang.build_types import TypeBuilder
from seoro.lang.diagnostics import syntax
from seoro.lang.lexer import Token
from seoro.lang.source import Span


class Builder(TypeBuilder):
    """Makes the nodes of one file.

    Args:
        file: The file.
        bag: Where messages go.
    """

    # ------------------------------------------------------------ 7.2.2.1 top level

    def osc_file(self, span: Span, *statements: ast.Statement) -> ast.OscFile:
        """The file; imports come first."""
        is_prelude = True
        for statement in statements:
            if isinstance(statement, ast.ImportModule | ast.ImportUri):
                if not is_prelude:
                    self._bag.add(syntax.LateImport(statement.span))
            elif not isinstance(statement, ast.InvalidStatement):
                is_prelude = False
        return ast.OscFile(statements, (), span)

    def lone_expression(self, span: Span, expression: ast.Expression) -> ast.Expression:
        """An expression on its own."""
        return expression

    def invalid_statement(self, span: Span, token: Token) -> ast.InvalidStatement:
        """What could not be parsed."""
        return ast.InvalidStatement(span)

    def invalid_member(self, span: Span, token: Token) -> ast.DoMember:
        """A behavior that could not be parsed."""
        return ast.DoMember(None, ast.InvalidStatement(span), span)

    def import_statement(self, span: Span, reference: ast.ImportStatement | list[str]) -> ast.ImportStatement:
        """`import ...`."""
        if isinstance(reference, list):
            return ast.ImportModule(tuple(reference), span)
        return reference

    def import_uri(self, span: Span, text: Token) -> ast.ImportUri:
        """The string of an import."""
        return ast.ImportUri(text.value, span)

    def structured_identifier(self, span: Span, *names: Token) -> list[str]:
        """`a.b.c`."""
        return [bare(name.value) for name in names]

    def namespace_statement(self, span: Span, name: str, uses: tuple[str, ...] | None) -> ast.NamespaceStatement:
        """`namespace ...`."""
        return ast.NamespaceStatement(name, uses or (), span)

    def namespace_list(self, span: Span, *names: str) -> tuple[str, ...]:
        """The namespaces in use."""
        return names

    def namespace_name(self, span: Span, name: Token) -> str:
        """A namespace."""
        return bare(name.value)

    def export_statement(self, span: Span, *items: ast.Name | ast.ExportWildcard) -> ast.ExportStatement:
        """`export ...`."""
        return ast.ExportStatement(items, span)

    def export_wildcard_specification(self, span: Span, prefix: Token | None = None) -> ast.ExportWildcard:
        """`*`, with or without a namespace."""
        if prefix is None or "::" not in prefix.value:
            return ast.ExportWildcard(None, span)
        return ast.ExportWildcard(bare(prefix.value.partition("::")[0]) or "null", span)

    # ------------------------------------------------------------ 7.2.2.4 members

    def event_declaration(
        self,
        span: Span,
        name: ast.Name,
        parameters: tuple[ast.ArgumentSpecification, ...] | None,
        specification: Any,
    ) -> ast.EventDeclaration:
        """`event ...`."""
        return ast.EventDeclaration(name, parameters or (), _condition(specification), span)

    def event_occurrence(
        self, span: Span, path: ast.Expression, name: ast.Name | None, condition: Any
    ) -> ast.EventOccurrence:
        """`@event ...`."""
        return ast.EventOccurrence(path, name, _condition(condition), span)

    def rise_expression(self, span: Span, condition: ast.Expression) -> ast.RiseExpression:
        """`rise(...)`."""
        return ast.RiseExpression(condition, span)

    def fall_expression(self, span: Span, condition: ast.Expression) -> ast.FallExpression:
        """`fall(...)`."""
        return ast.FallExpression(condition, span)

    def elapsed_expression(self, span: Span, duration: ast.Expression) -> ast.ElapsedExpression:
        """`elapsed(...)`."""
        return ast.ElapsedExpression(duration, span)

    def every_expression(
        self, span: Span, period: ast.Expression, offset: ast.Expression | None
    ) -> ast.EveryExpression:
        """`every(...)`."""
        return ast.EveryExpression(period, offset, span)

    def parameter_declaration(
        self,
        span: Span,
        names: tuple[ast.Name, ...],
        type_: ast.TypeDeclarator,
        default: ast.Expression | None,
        members: tuple[Any, ...] = (),
    ) -> ast.ParameterDeclaration:
        """A parameter, or several of one type."""
        coverage = tuple(member for member in members if isinstance(member, ast.CoverageDeclaration))
        constraints = tuple(member for member in members if not isinstance(member, ast.CoverageDeclaration))
        return ast.ParameterDeclaration(names, type_, default, constraints, coverage, span)

    def parameter_with_declaration(self, span: Span, *members: Any) -> tuple[Any, ...]:
        """The `with:` block of a parameter."""
        return members

    def variable_declaration(
        self, span: Span, names: tuple[ast.Name, ...], type_: ast.TypeDeclarator, value: Any
    ) -> ast.VariableDeclaration:
        """`var ...`."""
        return ast.VariableDeclaration(names, type_, value, span)

    def field_names(self, span: Span, *names: ast.Name) -> tuple[ast.Name, ...]:
        """`a, b, c`."""
        return names

    def sample_expression(
        self, span: Span, value: ast.Expression, event: Any, default: ast.Expression | None
    ) -> ast.SampleExpression:
        """`sample(...)`."""
        specification = _condition(event)
        assert specification is not None
        return ast.SampleExpression(value, specification, default, span)

    def keep_constraint_declaration(
        self, span: Span, qualifier: str | None, constraint: ast.Expression
    ) -> ast.KeepConstraint:
        """`keep(...)`."""
        return ast.KeepConstraint(qualifier, constraint, span)

    def constraint_qualifier(self, span: Span, word: Token) -> str:
        """`default` or `hard`."""
        return str(word.value)

    def remove_default_declaration(self, span: Span, parameter: ast.Expression) -> ast.RemoveDefault:
        """`remove_default(...)`."""
        return ast.RemoveDefault(parameter, span)

    def method_declaration(
        self,
        span: Span,
        name: ast.Name,
        parameters: tuple[ast.ArgumentSpecification, ...] | None,
        result: ast.TypeDeclarator | None,
        qualifier: bool | None,
        implementation: Any,
    ) -> ast.MethodDeclaration:
        """`def ...`."""
        return ast.MethodDeclaration(name, parameters or (), result, bool(qualifier), implementation, span)

    def method_qualifier(self, span: Span, word: Token) -> bool:
        """`only`."""
        return True

    def expression_method(self, span: Span, value: ast.Expression) -> ast.ExpressionMethod:
        """`expression ...`."""
        return ast.ExpressionMethod(value, span)

    def undefined_method(self, span: Span) -> ast.UndefinedMethod:
        """`undefined`."""
        return ast.UndefinedMethod(span)

    def external_method(
        self, span: Span, path: list[str], arguments: ast.ArgumentList | None
    ) -> ast.ExternalMethod:
        """`external ...`."""
        return ast.ExternalMethod(tuple(path), arguments or ast.ArgumentList((), (), span), span)

    def coverage_declaration(self, span: Span, kind: str, arguments: ast.ArgumentList) -> ast.CoverageDeclaration:
        """`cover(...)` or `record(...)`."""
        return ast.CoverageDeclaration(kind, arguments, span)

    def coverage_kind(self, span: Span, word: Token) -> str:
        """`cover` or `record`."""
        return str(word.value)

    def modifier_application(self, span: Span, invocation: ast.FunctionApplication) -> ast.ModifierApplication:
        """A modifier with its arguments."""
        return ast.ModifierApplication(invocation, span)

    def on_directive(self, span: Span, event: Any, *members: Any) -> ast.OnDirective:
        """`on ...`."""
        specification = _condition(event)
        assert specification is not None
        return ast.OnDirective(specification, members, span)

    def do_directive(self, span: Span, member: ast.DoMember) -> ast.DoDirective:
        """`do ...`."""
        return ast.DoDirective(member, span)

    def do_member(self, span: Span, label: ast.Name | None, body: Any) -> ast.DoMember:
        """A behavior with or without its label."""
        return ast.DoMember(label, body, span)

    def composition(
        self, span: Span, operator: str, arguments: tuple[ast.ArgumentList | None] | None, *rest: Any
    ) -> ast.Composition:
        """`serial: ...` and its like."""
        *members, modifications = rest
        given = arguments[0] if arguments is not None else None
        return ast.Composition(operator, given, tuple(members), modifications, span)

    def composition_arguments(
        self, span: Span, arguments: ast.ArgumentList | None
    ) -> tuple[ast.ArgumentList | None]:
        """`(duration: ...)`."""
        return (arguments,)

    def composition_operator(self, span: Span, word: Token) -> str:
        """`serial`, `parallel` or `one_of`."""
        return str(word.value)

    def behavior_invocation(
        self, span: Span, invocation: ast.FunctionApplication, modifications: ast.WithBlock | None = None
    ) -> ast.BehaviorInvocation:
        """An action or a scenario with its arguments."""
        return ast.BehaviorInvocation(invocation, modifications, span)

    def behavior_with_declaration(self, span: Span, *members: Any) -> ast.WithBlock:
        """A `with:` block."""
        return ast.WithBlock(members, span)

    def wait_directive(self, span: Span, event: Any) -> ast.WaitDirective:
        """`wait ...`."""
        specification = _condition(event)
        assert specification is not None
        return ast.WaitDirective(specification, span)

    def emit_directive(self, span: Span, event: ast.Name, arguments: ast.ArgumentList | None) -> ast.EmitDirective:
        """`emit ...`."""
        return ast.EmitDirective(event, arguments, span)

    def call_directive(self, span: Span, invocation: ast.FunctionApplication) -> ast.CallDirective:
        """`call ...`."""
        return ast.CallDirective(invocation, span)

    def until_directive(self, span: Span, event: Any) -> ast.UntilDirective:
        """`until ...`."""
        specification = _condition(event)
        assert specification is not None
        return ast.UntilDirective(specification, span)


def _condition(specification: Any) -> Any:
    """An expression in the place of an event condition becomes one."""
    if specification is None or isinstance(
        specification,
        ast.EventOccurrence
        | ast.RiseExpression
        | ast.FallExpression
        | ast.ElapsedExpression
        | ast.EveryExpression,
    ):
        return specification
    return ast.BoolCondition(specification, specification.span)
