"""Syntax tree of a file, before name resolution.

Nodes are named after the productions of section 7.2.2. They are immutable, have no methods, and hold their spans.
Results of the checker are stored separately (`symbols.py`).
"""

from __future__ import annotations

from typing import TypeAlias

from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class Node(Frozen):
    """Base of the nodes."""


# ---------------------------------------------------------------- names and types


class Name(Node):
    """A qualified identifier; `namespace` is the prefix, if any: `null` for the global namespace."""

    text: str
    namespace: str | None
    span: Span


class BehaviorName(Node):
    """`[actor.]name`."""

    actor: Name | None
    name: Name
    span: Span


class PrimitiveTypeName(Node):
    """`bool`, `int`, `uint`, `float` or `string`."""

    text: str
    span: Span


class NamedType(Node):
    """A declared type."""

    name: BehaviorName
    span: Span


class ListTypeDeclarator(Node):
    """`list of <element>`."""

    element: TypeDeclarator
    span: Span


class RangeTypeDeclarator(Node):
    """`range of <element>`."""

    element: TypeDeclarator
    span: Span


TypeDeclarator: TypeAlias = PrimitiveTypeName | NamedType | ListTypeDeclarator | RangeTypeDeclarator

# ---------------------------------------------------------------- expressions


class IntegerLiteral(Node):
    """An integer, including the sign of a negative one."""

    value: int
    span: Span


class FloatLiteral(Node):
    """A number with a fraction or an exponent, `inf` or `nan`."""

    value: float
    span: Span


class PhysicalLiteral(Node):
    """A number with a unit."""

    value: int | float
    unit: Name
    span: Span


class BoolLiteral(Node):
    """`true` or `false`."""

    value: bool
    span: Span


class StringLiteral(Node):
    """A string, its escapes resolved."""

    value: str
    span: Span


class EnumValueReference(Node):
    """`[<enum>!]<member>`."""

    enum: Name | None
    member: Name
    span: Span


class It(Node):
    """`it`."""

    span: Span


class NameExpression(Node):
    """A name in an expression: a field, a member of an enumeration, or a callee."""

    name: Name
    span: Span


class FieldAccess(Node):
    """`<base>.<name>`."""

    base: Expression
    name: Name
    span: Span


class ElementAccess(Node):
    """`<base>[<position>]`."""

    base: Expression
    position: Expression
    span: Span


class FunctionApplication(Node):
    """`<function>(<arguments>)`."""

    function: Expression
    arguments: ArgumentList
    span: Span


class CastExp(Node):
    """`<base>.as(<type>)`."""

    base: Expression
    type: TypeDeclarator
    span: Span


class TypeTestExp(Node):
    """`<base>.is(<type>)`."""

    base: Expression
    type: TypeDeclarator
    span: Span


class Negation(Node):
    """`-<operand>`."""

    operand: Expression
    span: Span


class Inversion(Node):
    """`not <operand>`."""

    operand: Expression
    span: Span


class Arithmetic(Node):
    """`+ - * / %` of two operands."""

    operator: str
    left: Expression
    right: Expression
    span: Span


class Relation(Node):
    """`== != < <= > >= in`."""

    operator: str
    left: Expression
    right: Expression
    span: Span


class Logic(Node):
    """`and`, `or`, `=>`."""

    operator: str
    left: Expression
    right: Expression
    span: Span


class TernaryOpExp(Node):
    """`<condition> ? <then> : <otherwise>`."""

    condition: Expression
    then: Expression
    otherwise: Expression
    span: Span


class ListConstructor(Node):
    """`[a, b]`."""

    items: tuple[Expression, ...]
    span: Span


class RangeConstructor(Node):
    """`[a..b]` or `range(a, b)`."""

    low: Expression
    high: Expression
    span: Span


Expression: TypeAlias = (
    IntegerLiteral
    | FloatLiteral
    | PhysicalLiteral
    | BoolLiteral
    | StringLiteral
    | EnumValueReference
    | It
    | NameExpression
    | FieldAccess
    | ElementAccess
    | FunctionApplication
    | CastExp
    | TypeTestExp
    | Negation
    | Inversion
    | Arithmetic
    | Relation
    | Logic
    | TernaryOpExp
    | ListConstructor
    | RangeConstructor
)


class NamedArgument(Node):
    """`<name>: <value>`."""

    name: Name
    value: Expression
    span: Span


class ArgumentList(Node):
    """Positional arguments, then named ones."""

    positional: tuple[Expression, ...]
    named: tuple[NamedArgument, ...]
    span: Span


class ArgumentSpecification(Node):
    """A parameter of an event or a method."""

    name: Name
    type: TypeDeclarator
    default: Expression | None
    span: Span


# ---------------------------------------------------------------- events


class EventOccurrence(Node):
    """`@<path> [[as <name>] if <condition>]`; the path is kept as the expression it looks like."""

    path: Expression
    name: Name | None
    condition: EventCondition | None
    span: Span


class RiseExpression(Node):
    """`rise(<condition>)`."""

    condition: Expression
    span: Span


class FallExpression(Node):
    """`fall(<condition>)`."""

    condition: Expression
    span: Span


class ElapsedExpression(Node):
    """`elapsed(<duration>)`."""

    duration: Expression
    span: Span


class EveryExpression(Node):
    """`every(<period>[, offset: <offset>])`."""

    period: Expression
    offset: Expression | None
    span: Span


class BoolCondition(Node):
    """An expression that is true or false."""

    condition: Expression
    span: Span


EventCondition: TypeAlias = BoolCondition | RiseExpression | FallExpression | ElapsedExpression | EveryExpression
EventSpecification: TypeAlias = EventOccurrence | EventCondition

# ---------------------------------------------------------------- behaviors


class Composition(Node):
    """`serial`, `parallel` or `one_of` with its members."""

    operator: str
    arguments: ArgumentList | None
    members: tuple[DoMember, ...]
    modifications: WithBlock | None
    span: Span


class BehaviorInvocation(Node):
    """`[<actor>.]<behavior>(<arguments>)`; name resolution decides which part is the actor."""

    invocation: FunctionApplication
    modifications: WithBlock | None
    span: Span


class WaitDirective(Node):
    """`wait <event specification>`."""

    event: EventSpecification
    span: Span


class EmitDirective(Node):
    """`emit <event>[(<arguments>)]`."""

    event: Name
    arguments: ArgumentList | None
    span: Span


class CallDirective(Node):
    """`call <method>(<arguments>)`."""

    invocation: FunctionApplication
    span: Span


class InvalidStatement(Node):
    """A statement that could not be parsed; its error has been reported."""

    span: Span


DoBody: TypeAlias = (
    Composition | BehaviorInvocation | WaitDirective | EmitDirective | CallDirective | InvalidStatement
)


class DoMember(Node):
    """`[<label>:] <behavior>`."""

    label: Name | None
    body: DoBody
    span: Span


class UntilDirective(Node):
    """`until <event specification>`."""

    event: EventSpecification
    span: Span


# ---------------------------------------------------------------- members


class EventDeclaration(Node):
    """`event <name>[(<parameters>)] [is <specification>]`."""

    name: Name
    parameters: tuple[ArgumentSpecification, ...]
    specification: EventSpecification | None
    span: Span


class ParameterDeclaration(Node):
    """`<names>: <type> [= <default>] [with: ...]`."""

    names: tuple[Name, ...]
    type: TypeDeclarator
    default: Expression | None
    constraints: tuple[ConstraintDeclaration | InvalidStatement, ...]
    coverage: tuple[CoverageDeclaration, ...]
    span: Span


class SampleExpression(Node):
    """`sample(<value>, <event>[, <default>])`."""

    value: Expression
    event: EventSpecification
    default: Expression | None
    span: Span


class VariableDeclaration(Node):
    """`var <names>: <type> [= <value>]`."""

    names: tuple[Name, ...]
    type: TypeDeclarator
    value: Expression | SampleExpression | None
    span: Span


class KeepConstraint(Node):
    """`keep([default | hard] <constraint>)`."""

    qualifier: str | None
    constraint: Expression
    span: Span


class RemoveDefault(Node):
    """`remove_default(<parameter>)`."""

    parameter: Expression
    span: Span


class ExpressionMethod(Node):
    """`is expression <value>`."""

    value: Expression
    span: Span


class UndefinedMethod(Node):
    """`is undefined`."""

    span: Span


class ExternalMethod(Node):
    """`is external <path>(<arguments>)`."""

    path: tuple[str, ...]
    arguments: ArgumentList
    span: Span


class MethodDeclaration(Node):
    """`def <name>(<parameters>) [-> <type>] is [only] <implementation>`."""

    name: Name
    parameters: tuple[ArgumentSpecification, ...]
    result: TypeDeclarator | None
    only: bool
    implementation: ExpressionMethod | UndefinedMethod | ExternalMethod
    span: Span


class CoverageDeclaration(Node):
    """`cover(...)` or `record(...)`."""

    kind: str
    arguments: ArgumentList
    span: Span


class ModifierApplication(Node):
    """`[<actor>.]<modifier>(<arguments>)`."""

    invocation: FunctionApplication
    span: Span


class OnDirective(Node):
    """`on <event specification>: ...`."""

    event: EventSpecification
    members: tuple[CallDirective | EmitDirective | InvalidStatement, ...]
    span: Span


class DoDirective(Node):
    """`do <member>`."""

    member: DoMember
    span: Span


class WithBlock(Node):
    """The `with:` block of an invocation or a composition."""

    members: tuple[ConstraintDeclaration | ModifierApplication | UntilDirective | InvalidStatement, ...]
    span: Span


ConstraintDeclaration: TypeAlias = KeepConstraint | RemoveDefault
TypeMember: TypeAlias = (
    EventDeclaration
    | ParameterDeclaration
    | VariableDeclaration
    | ConstraintDeclaration
    | MethodDeclaration
    | CoverageDeclaration
    | ModifierApplication
    | OnDirective
    | DoDirective
    | InvalidStatement
)

# ---------------------------------------------------------------- statements


class ImportModule(Node):
    """`import a.b.c`."""

    path: tuple[str, ...]
    span: Span


class ImportUri(Node):
    """`import "path/or/uri.osc"`."""

    uri: str
    span: Span


ImportStatement: TypeAlias = ImportModule | ImportUri


class NamespaceStatement(Node):
    """`namespace <name> [use <names>]`."""

    name: str
    uses: tuple[str, ...]
    span: Span


class ExportWildcard(Node):
    """`*` or `<namespace>::*` in an export."""

    namespace: str | None
    span: Span


class ExportStatement(Node):
    """`export <names>`."""

    items: tuple[Name | ExportWildcard, ...]
    span: Span


class SiBaseExponent(Node):
    """`<base unit>: <exponent>`."""

    unit: str
    exponent: int
    span: Span


class PhysicalTypeDeclaration(Node):
    """`type <name> is SI(...)`."""

    name: Name
    exponents: tuple[SiBaseExponent, ...]
    span: Span


class UnitDeclaration(Node):
    """`unit <name> of <type> is SI(...)`."""

    name: Name
    quantity: Name
    exponents: tuple[SiBaseExponent, ...]
    factor: float
    offset: float
    span: Span


class EnumMemberDecl(Node):
    """`<name> [= <number or member>]`."""

    name: Name
    value: int | EnumValueReference | None
    span: Span


class EnumDeclaration(Node):
    """`enum <name>: [...]`."""

    name: Name
    members: tuple[EnumMemberDecl, ...]
    span: Span


class Inheritance(Node):
    """`inherits <name> [(<field> == <value>)]`."""

    base: BehaviorName
    condition: tuple[Name, EnumValueReference | BoolLiteral] | None
    span: Span


class StructDeclaration(Node):
    """`struct ...`."""

    name: Name
    inheritance: Inheritance | None
    members: tuple[TypeMember, ...]
    span: Span


class ActorDeclaration(Node):
    """`actor ...`."""

    name: Name
    inheritance: Inheritance | None
    members: tuple[TypeMember, ...]
    span: Span


class ScenarioDeclaration(Node):
    """`scenario ...`."""

    name: BehaviorName
    inheritance: Inheritance | None
    members: tuple[TypeMember, ...]
    span: Span


class ActionDeclaration(Node):
    """`action ...`."""

    name: BehaviorName
    inheritance: Inheritance | None
    members: tuple[TypeMember, ...]
    span: Span


class ModifierDeclaration(Node):
    """`modifier [<actor>.]<name> [of <behavior>] ...`."""

    name: BehaviorName
    of: BehaviorName | None
    members: tuple[TypeMember, ...]
    span: Span


class EnumTypeExtension(Node):
    """`extend <enum>: [...]`."""

    name: Name
    members: tuple[EnumMemberDecl, ...]
    span: Span


class StructuredTypeExtension(Node):
    """`extend <type>: ...`."""

    name: BehaviorName
    members: tuple[TypeMember, ...]
    span: Span


class PrimitiveTypeExtension(Node):
    """`extend <primitive type>: ...`."""

    type: PrimitiveTypeName
    members: tuple[MethodDeclaration | InvalidStatement, ...]
    span: Span


class GlobalParameterDeclaration(Node):
    """`global <parameter>`."""

    parameter: ParameterDeclaration
    span: Span


StructuredTypeDeclaration: TypeAlias = (
    StructDeclaration | ActorDeclaration | ScenarioDeclaration | ActionDeclaration | ModifierDeclaration
)
OscDeclaration: TypeAlias = (
    PhysicalTypeDeclaration
    | UnitDeclaration
    | EnumDeclaration
    | StructuredTypeDeclaration
    | EnumTypeExtension
    | StructuredTypeExtension
    | PrimitiveTypeExtension
    | GlobalParameterDeclaration
)
Statement: TypeAlias = ImportStatement | NamespaceStatement | ExportStatement | OscDeclaration | InvalidStatement


class OscFile(Node):
    """A whole file.

    `unread` has the names that statements with syntax errors may declare; None if they may declare any name.
    """

    statements: tuple[Statement, ...]
    unread: tuple[str, ...] | None
    span: Span
