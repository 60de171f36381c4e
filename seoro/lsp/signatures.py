"""Signature help: the parameters of the call at the cursor."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol.types import ParameterInformation, SignatureInformation

from seoro.lsp.analysis import Analysis
from seoro.lsp.completion import current_parameter
from seoro.lsp.cursor import read_cursor
from seoro.lsp.cursor_context import callee, cursor_context
from seoro.lsp.describe import comment, parameter_text, parameters_of, signature


def signature_at(text: str, offset: int, analyses: Sequence[Analysis]) -> SignatureInformation | None:
    """Return the signature of the innermost call around the cursor; None without a call, or if it is unknown.

    Args:
        text: Current text.
        offset: Offset of the cursor.
        analyses: Analyses of the document, newest first; at least one.
    """
    cursor = read_cursor(text, offset)
    if cursor is None:
        return None
    around = cursor_context(cursor, analyses)
    called = callee(around)
    if called is None:
        return None
    parameters = parameters_of(called).values()
    names = [parameter.text for parameter in parameters]
    return SignatureInformation(
        signature(called, around.program),
        comment(called),
        [ParameterInformation(parameter_text(parameter, around.program)) for parameter in parameters],
        current_parameter(cursor, names),
    )
