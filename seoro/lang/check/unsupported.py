"""Refuses, by name, what the standard has and seoro does not support yet.

Statements and members are refused here; constructs within expressions and behaviors are refused where they are
met. What is refused is not looked at any further, so that it causes no other messages.
"""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics.unsupported import Construct, NotSupported
from seoro.lang.source import Span
from seoro.lang.symbols import Program


def head(span: Span, word: str) -> Span:
    """The word with which a statement begins."""
    return Span(span.file, span.start, min(span.start + len(word), span.end))


def refuse_statement(statement: ast.Statement, program: Program, bag: Bag) -> bool:
    """Report a statement of a user's file that is not supported; names that it declares may then be missing."""
    match statement:
        case ast.ModifierDeclaration(name, span=span):
            refused = NotSupported(head(span, "modifier"), Construct.MODIFIER_DECLARATION, name.name.text)
        case _:
            return False
    bag.add(refused)
    program.is_lenient = True
    return True


def refuse_member(member: ast.TypeMember, bag: Bag) -> bool:
    """Report a member of a type that is not supported."""
    match member:
        case ast.ModifierApplication(invocation, span=span):
            bag.add(NotSupported(span, Construct.MODIFIER_APPLICATION, name_of(invocation)))
        case ast.OnDirective(span=span):
            bag.add(NotSupported(head(span, "on"), Construct.ON))
        case ast.VariableDeclaration(value=ast.SampleExpression(span=span)):
            bag.add(NotSupported(head(span, "sample"), Construct.SAMPLE))
        case ast.EventDeclaration(name, specification=specification) if specification is not None:
            bag.add(NotSupported(specification.span, Construct.EVENT_IS, name.text))
        case _:
            return False
    return True


def refuse_with(block: ast.WithBlock | None, bag: Bag, is_invocation: bool = False) -> None:
    """Report what a `with:` block of a behavior has besides the constraints of an invocation."""
    members = block.members if block is not None else ()
    allowed = ast.KeepConstraint | ast.RemoveDefault | ast.InvalidStatement
    if block is not None and not (is_invocation and all(isinstance(member, allowed) for member in members)):
        bag.add(NotSupported(head(block.span, "with"), Construct.WITH))


def name_of(invocation: ast.FunctionApplication) -> str:
    """The last name of what is applied to arguments."""
    match invocation.function:
        case ast.NameExpression(name) | ast.FieldAccess(_, name):
            return name.text
        case _:
            return ""
