"""From the parser's reductions to the tree: one method for each production that has a node.

The methods are called by `parser.py` with the production's span and those children that the grammar keeps; an
absent optional part is None. What the grammar leaves open and the standard does not (the order of arguments,
the ranges of numbers) is checked here.
"""

from __future__ import annotations

from typing import Any

from seoro.lang import ast
from seoro.lang.build_expressions import ExpressionBuilder, bare
from seoro.lang.diagnostics import syntax
from seoro.lang.lexer import Number, Token
from seoro.lang.source import Span


class Builder(ExpressionBuilder):
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
        return ast.OscFile(statements, span)

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

    # ------------------------------------------------------------ 7.2.2.2 types

    def physical_type_declaration(
        self, span: Span, name: ast.Name, exponents: tuple[ast.SiBaseExponent, ...]
    ) -> ast.PhysicalTypeDeclaration:
        """`type ...`."""
        return ast.PhysicalTypeDeclaration(name, exponents, span)

    def base_unit_specifier(self, span: Span, *exponents: ast.SiBaseExponent) -> tuple[ast.SiBaseExponent, ...]:
        """`SI(...)` of a type."""
        return exponents

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

    def si_factor(self, span: Span, value: float) -> float:
        """`factor: ...`."""
        return value

    def si_offset(self, span: Span, value: float) -> float:
        """`offset: ...`."""
        return value

    def signed_integer(self, span: Span, sign: Token | None, digits: Token) -> int:
        """A whole number."""
        number: Number = digits.value
        return -int(number.value) if sign is not None else int(number.value)

    def signed_number(self, span: Span, sign: Token | None, digits: Token) -> float:
        """A number."""
        number: Number = digits.value
        return -float(number.value) if sign is not None and sign.kind == "MINUS" else float(number.value)

    def enum_declaration(
        self, span: Span, name: ast.Name, members: tuple[ast.EnumMemberDecl, ...]
    ) -> ast.EnumDeclaration:
        """`enum ...`."""
        return ast.EnumDeclaration(name, members, span)

    def enum_members(self, span: Span, *members: ast.EnumMemberDecl) -> tuple[ast.EnumMemberDecl, ...]:
        """`[...]` of an enumeration."""
        return members

    def enum_member_decl(
        self, span: Span, name: ast.Name, value: int | ast.EnumValueReference | None
    ) -> ast.EnumMemberDecl:
        """A member of an enumeration."""
        return ast.EnumMemberDecl(name, value, span)

    def enum_number(self, span: Span, digits: Token) -> int:
        """A member's number."""
        number: Number = digits.value
        return int(number.value)

    def enum_value_reference(self, span: Span, enum: ast.Name | None, member: ast.Name) -> ast.EnumValueReference:
        """A member, with or without its enumeration."""
        return ast.EnumValueReference(enum, member, span)

    def inheritance(
        self, span: Span, base: ast.BehaviorName, condition: tuple[ast.Name, Any] | None
    ) -> ast.Inheritance:
        """`inherits ...`."""
        return ast.Inheritance(base, condition, span)

    def inheritance_condition(self, span: Span, field: ast.Name, value: Any) -> tuple[ast.Name, Any]:
        """`(field == value)`."""
        return field, value

    def struct_declaration(
        self, span: Span, name: ast.Name, inheritance: ast.Inheritance | None, *members: ast.TypeMember
    ) -> ast.StructDeclaration:
        """`struct ...`."""
        return ast.StructDeclaration(name, inheritance, members, span)

    def actor_declaration(
        self, span: Span, name: ast.Name, inheritance: ast.Inheritance | None, *members: ast.TypeMember
    ) -> ast.ActorDeclaration:
        """`actor ...`."""
        return ast.ActorDeclaration(name, inheritance, members, span)

    def scenario_declaration(
        self, span: Span, name: ast.BehaviorName, inheritance: ast.Inheritance | None, *members: ast.TypeMember
    ) -> ast.ScenarioDeclaration:
        """`scenario ...`."""
        return ast.ScenarioDeclaration(name, inheritance, members, span)

    def action_declaration(
        self, span: Span, name: ast.BehaviorName, inheritance: ast.Inheritance | None, *members: ast.TypeMember
    ) -> ast.ActionDeclaration:
        """`action ...`."""
        return ast.ActionDeclaration(name, inheritance, members, span)

    def modifier_declaration(
        self, span: Span, name: ast.BehaviorName, of: ast.BehaviorName | None, *members: ast.TypeMember
    ) -> ast.ModifierDeclaration:
        """`modifier ...`."""
        return ast.ModifierDeclaration(name, of, members, span)

    def enum_type_extension(
        self, span: Span, name: ast.Name, members: tuple[ast.EnumMemberDecl, ...]
    ) -> ast.EnumTypeExtension:
        """`extend <enum>: [...]`."""
        return ast.EnumTypeExtension(name, members, span)

    def structured_type_extension(self, span: Span, *parts: Any) -> ast.StructuredTypeExtension:
        """`extend <type>: ...`; the type's name is one name or two."""
        names = [part for part in parts if isinstance(part, ast.Name)]
        actor = names[0] if len(names) == 2 else None
        name = ast.BehaviorName(actor, names[-1], names[0].span.to(names[-1].span))
        return ast.StructuredTypeExtension(name, tuple(parts[len(names) :]), span)

    def primitive_type_extension(
        self, span: Span, primitive: ast.PrimitiveTypeName, *members: ast.MethodDeclaration | ast.InvalidStatement
    ) -> ast.PrimitiveTypeExtension:
        """`extend <primitive type>: ...`."""
        return ast.PrimitiveTypeExtension(primitive, members, span)

    def global_parameter_declaration(
        self, span: Span, parameter: ast.ParameterDeclaration
    ) -> ast.GlobalParameterDeclaration:
        """`global ...`."""
        return ast.GlobalParameterDeclaration(parameter, span)

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
