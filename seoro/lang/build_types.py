"""From the parser's reductions to the tree: declarations of types (7.2.2.2). `build.py` has the rest."""

from __future__ import annotations

from typing import Any

from seoro.lang import ast
from seoro.lang.build_expressions import ExpressionBuilder, bare
from seoro.lang.lexer import Number, Token
from seoro.lang.source import Span


class TypeBuilder(ExpressionBuilder):
    """Makes the nodes of declarations of types.

    Args:
        file: The file.
        bag: Where messages go.
    """

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
