"""The parameters of what is being called at the cursor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from seoro.lsp.analysis import Analysis
from seoro.lsp.completion import arguments_before
from seoro.lsp.cursor import read_cursor
from seoro.lsp.describe import comment, parameter_text, parameters_of, signature
from seoro.lsp.regions import behavior_start
from seoro.lsp.surroundings import callee, surroundings


@dataclass(frozen=True)
class Signature:
    """What takes arguments.

    Args:
        label: Its name with all parameters.
        documentation: What its author says of it.
        parameters: Each as it stands in the label.
        active: The number of the one that the cursor is at; None if there is none.
    """

    label: str
    documentation: str
    parameters: tuple[str, ...]
    active: int | None


def signature_at(text: str, offset: int, analyses: Sequence[Analysis]) -> Signature | None:
    """What the innermost call around a place in a text takes; None if there is no call, or it is not known.

    Args:
        text: As it is now.
        offset: Of the cursor.
        analyses: Of the document, the newest first; at least one.
    """
    cursor = read_cursor(text, offset)
    if cursor is None or not cursor.brackets or not cursor.brackets[-1].is_call:
        return None
    around = surroundings(cursor, analyses)
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
