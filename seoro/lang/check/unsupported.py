"""Refuses, by name, what the standard has and seoro does not support yet.

Members are refused here; constructs within expressions and behaviors are refused where they are
met. What is refused is not looked at any further, so that it causes no other messages.
"""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics.unsupported import Construct, NotSupported
from seoro.lang.source import Span


def head(span: Span, word: str) -> Span:
    """The word with which a statement begins."""
    return Span(span.file, span.start, min(span.start + len(word), span.end))


def refuse_member(member: ast.TypeMember, bag: Bag) -> bool:
    """Report a member of a type that is not supported."""
    match member:
        case ast.VariableDeclaration(value=ast.SampleExpression(span=span)):
            bag.add(NotSupported(head(span, "sample"), Construct.SAMPLE))
        case _:
            return False
    return True
