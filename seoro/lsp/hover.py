"""Hover texts: information about the symbol under the pointer."""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.source import Span
from seoro.lang.symbols import UnitSymbol, Unknown
from seoro.lang.tree import find
from seoro.lang.units import to_si, unit_text
from seoro.lsp.analysis import Analysis, library_at
from seoro.lsp.describe import code, comment, declaration, kind, typed
from seoro.lsp.meaning import ImportedFile, Meaning, definition


def hover(analysis: Analysis, offset: int) -> tuple[str, Span] | None:
    """Return the hover text at an offset, in Markdown, and its span.

    Args:
        analysis: Analysis of the document.
        offset: Offset into its text.
    """
    literal = _literal(analysis.tree, offset)
    if literal is not None:
        return _quantity(literal, analysis)
    use = analysis.index.at(analysis.path, offset)
    if use is not None:
        return about(use.meaning, analysis), use.span
    return _value(analysis, offset)


def about(meaning: Meaning, analysis: Analysis) -> str:
    """Return the hover text of a declaration."""
    program = analysis.checked.program
    parts = [code(declaration(meaning, program)), _with_origin(kind(meaning, program), meaning, analysis)]
    if isinstance(meaning, ImportedFile):
        parts[-1] += f" at `{meaning.path}`"
    parts.append(comment(meaning))
    return "\n\n".join(part for part in parts if part)


def _with_origin(text: str, meaning: Meaning, analysis: Analysis) -> str:
    """Append the library or file that declares the symbol."""
    span = definition(meaning)
    path = analysis.files.path_of(span.file) if span is not None else None
    if path is None or path == analysis.path:
        return text
    return f"{text} (from `{library_at(path) or path.name}`)"


def _literal(tree: ast.OscFile, offset: int) -> ast.PhysicalLiteral | None:
    """Return the number with a unit at an offset."""
    found = (node for node in find(tree, ast.PhysicalLiteral) if node.span.start <= offset <= node.span.end)
    return next(found, None)


def _quantity(literal: ast.PhysicalLiteral, analysis: Analysis) -> tuple[str, Span] | None:
    """Describe a number with a unit: its SI value, and the unit."""
    program = analysis.checked.program
    unit = program.units.get(literal.unit.text)
    if unit is None or unit.dimension is None:
        return None
    return f"{code(in_si(literal, unit))}\n\n{_with_origin(kind(unit, program), unit, analysis)}", literal.span


def in_si(literal: ast.PhysicalLiteral, unit: UnitSymbol) -> str:
    """Format a quantity with its SI value: `60kph = 16.67 m/s`."""
    assert unit.dimension is not None
    value = to_si(literal.value, unit.factor, unit.offset)
    return f"{literal.span.text} = {value:.4g} {unit_text(unit.dimension)}"


def _value(analysis: Analysis, offset: int) -> tuple[str, Span] | None:
    """Describe `it` or `actor` by its type, as it has no declaration."""
    found = analysis.index.type_at(analysis.path, offset)
    if found is None or found[0].text not in {"it", "actor"} or isinstance(found[1], Unknown):
        return None
    span, type_ = found
    return f"{code(span.text)}\n\n{typed(type_, analysis.checked.program)}", span
