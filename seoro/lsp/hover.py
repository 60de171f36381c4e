"""Hover texts: information about the symbol under the pointer."""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.source import Span
from seoro.lang.tree import find
from seoro.lang.units import to_si, unit_text
from seoro.lsp.analysis import Analysis, library_at
from seoro.lsp.describe import code, comment, described, typed
from seoro.lsp.meaning import ImportedFile, Meaning, definition


def hover(analysis: Analysis, offset: int) -> tuple[str, Span] | None:
    """Return the hover text at an offset, in Markdown, and its span.

    Args:
        analysis: Analysis of the document.
        offset: Offset into its text.
    """
    literals = find(analysis.tree, ast.PhysicalLiteral)
    literal = next((node for node in literals if node.span.start <= offset <= node.span.end), None)
    if literal is not None:
        return _quantity(literal, analysis)
    use = analysis.index.at(analysis.path, offset)
    if use is not None:
        return about(use.meaning, analysis), use.span
    return _value(analysis, offset)


def about(meaning: Meaning, analysis: Analysis) -> str:
    """Return the hover text of a declaration."""
    program = analysis.checked.program
    declaration, kind = described(meaning, program)
    place = f" at `{meaning.path}`" if isinstance(meaning, ImportedFile) else _origin(meaning, analysis)
    return "\n\n".join(filter(None, (code(declaration), kind + place, comment(meaning))))


def _origin(meaning: Meaning, analysis: Analysis) -> str:
    """Return the library or the other file that declares a symbol; empty for symbols of the document."""
    span = definition(meaning)
    path = analysis.files.path_of(span.file) if span is not None else None
    return f" (from `{library_at(path) or path.name}`)" if path is not None and path != analysis.path else ""


def _quantity(literal: ast.PhysicalLiteral, analysis: Analysis) -> tuple[str, Span] | None:
    """Describe a number with a unit: its SI value (`60kph = 16.67 m/s`), and the unit."""
    program = analysis.checked.program
    unit = program.units.get(literal.unit.text)
    if unit is None or unit.dimension is None:
        return None
    value = to_si(literal.value, unit.factor, unit.offset)
    shown = code(f"{literal.span.text} = {value:.4g} {unit_text(unit.dimension)}")
    _, kind = described(unit, program)
    return f"{shown}\n\n{kind}{_origin(unit, analysis)}", literal.span


def _value(analysis: Analysis, offset: int) -> tuple[str, Span] | None:
    """Describe `it` or `actor` by its type, as it has no declaration."""
    found = analysis.index.type_at(analysis.path, offset)
    if found is None or found[0].text not in {"it", "actor"}:
        return None
    span, type_ = found
    return f"{code(span.text)}\n\n{typed(type_, analysis.checked.program)}", span
