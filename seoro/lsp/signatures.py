"""Signature help: the parameters of the call at the cursor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from seoro.lsp.analysis import Analysis
from seoro.lsp.completion import arguments_before
from seoro.lsp.cursor import read_cursor
from seoro.lsp.cursor_context import callee, cursor_context
from seoro.lsp.describe import comment, parameter_text, parameters_of, signature
from seoro.lsp.regions import behavior_start


@dataclass(frozen=True)
class Signature:
    """A callable with its parameters.

    Args:
        label: Its name with all parameters.
        documentation: Comment of its declaration.
        parameters: The parameters, as in the label.
        active: Number of the parameter at the cursor, or None.
    """

    label: str
    documentation: str
    parameters: tuple[str, ...]
    active: int | None


def signature_at(text: str, offset: int, analyses: Sequence[Analysis]) -> Signature | None:
    """Return the signature of the innermost call around the cursor; None without a call, or if it is unknown.

    Args:
        text: Current text.
        offset: Offset of the cursor.
        analyses: Analyses of the document, newest first; at least one.
    """
    cursor = read_cursor(text, offset)
    if cursor is None or not cursor.brackets or not cursor.brackets[-1].is_call:
        return None
    around = cursor_context(cursor, analyses)
    called = callee(around, cursor.brackets[-1].index, behavior_start(cursor))
    if called is None:
        return None
    names = [parameter.text for parameter in parameters_of(called).values()]
    given = arguments_before(cursor)
    place = names.index(given[-1]) if given[-1] in names else len(given) - 1
    return Signature(
        signature(called, around.program),
        comment(called),
        tuple(parameter_text(parameter, around.program) for parameter in parameters_of(called).values()),
        place if place < len(names) and (not given[-1] or given[-1] in names) else None,
    )
