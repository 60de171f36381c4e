"""Statements that are valid here and for scenario_execution, but do not mean the same.

The differences were measured with scenario_execution 1.8.0.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from seoro.lang import ast
from seoro.lang.frozen import Value
from seoro.lang.source import Span
from seoro.lang.tree import find

_ENDS: Final = ("end", "fail")


class Note(Value):
    """Difference in meaning, at a place."""

    span: Span
    text: str


def notes_of(tree: ast.OscFile) -> tuple[Note, ...]:
    """Return the differences in a file, in the order of the text."""
    events = {event.name.text for event in find(tree, ast.EventDeclaration)}
    found = [*_waits(tree, events), *_after_ends(tree), *_negated_names(tree)]
    return tuple(sorted(found, key=lambda note: note.span.start))


def _waits(tree: ast.OscFile, events: set[str]) -> Iterator[Note]:
    """Yield waits for events that may have occurred before: those are not kept here."""
    for composition in find(tree, ast.Composition):
        if composition.operator != "serial":
            continue
        for member in composition.members[1:]:
            body = member.body
            if not isinstance(body, ast.WaitDirective) or not isinstance(body.event, ast.EventOccurrence):
                continue
            name = body.event.path.span.text
            if name in events:
                text = (
                    f"`{body.span.text}` waits for the next `{name}`; scenario_execution also accepts an earlier "
                    "one. If that is meant, keep it in a variable"
                )
                yield Note(body.span, text)


def _after_ends(tree: ast.OscFile) -> Iterator[Note]:
    """Yield members that follow the end of their scenario: they never run here."""
    for composition in find(tree, ast.Composition):
        if composition.operator != "serial":
            continue
        for member, following in zip(composition.members, composition.members[1:], strict=False):
            if isinstance(member.body, ast.EmitDirective) and member.body.event.text in _ENDS:
                end = f"emit {member.body.event.text}"
                yield Note(following.span, f"unreachable after `{end}`; scenario_execution runs it before the end")


def _negated_names(tree: ast.OscFile) -> Iterator[Note]:
    """Yield negated names, whose sign scenario_execution drops."""
    for negation in find(tree, ast.Negation):
        if isinstance(negation.operand, ast.NameExpression | ast.FieldAccess):
            yield Note(negation.span, f"`{negation.span.text}` is negative; scenario_execution drops the sign")
