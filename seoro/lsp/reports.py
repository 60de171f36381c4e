"""Conversion of diagnostics for editors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from lsprotocol import types as lsp

from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.lint.fixes import UNNECESSARY, deletion
from seoro.lang.lint.linter import with_lints
from seoro.lang.source import Span
from seoro.lsp.analysis import Analysis
from seoro.lsp.documents import Documents
from seoro.lsp.local_names import imports
from seoro.lsp.positions import Positions

SOURCE = "seoro"
_SEVERITIES = {Severity.ERROR: lsp.DiagnosticSeverity.Error, Severity.WARNING: lsp.DiagnosticSeverity.Warning}


def reports(
    own: Analysis, others: Iterable[Analysis], documents: Documents, positions: Positions
) -> list[lsp.Diagnostic]:
    """Return the diagnostics of a document.

    Errors in imported files appear there, if they are open, else at the import.

    Args:
        own: Analysis of the document.
        others: Analyses of documents that may import it.
        documents: The open documents.
        positions: For ranges.
    """
    found = [*_found_in(own.path, own), *_at_imports(own, documents)]
    for other in others:
        found += _found_in(own.path, other)
    unique: dict[tuple[str, str, int, int], Diagnostic] = {}
    for diagnostic in found:
        span = diagnostic.primary.span
        unique.setdefault((diagnostic.code, diagnostic.message, span.start, span.end), diagnostic)
    return [_shown(diagnostic, own, documents, positions) for diagnostic in unique.values()]


def fixes(analysis: Analysis) -> Iterator[tuple[Diagnostic, Span]]:
    """Yield the warnings of a document with safe fixes, and the sections to delete."""
    for diagnostic in _found_in(analysis.path, analysis):
        section = deletion(diagnostic)
        if section is not None:
            yield diagnostic, section


def _found_in(path: Path, analysis: Analysis) -> Iterator[Diagnostic]:
    is_entry = analysis.module is analysis.checked.sources.entry  # libraries have no lints
    for diagnostic in with_lints(analysis.checked) if is_entry else analysis.checked.diagnostics:
        if analysis.files.path_of(diagnostic.primary.span.file) == path:
            yield diagnostic


def _shown(
    diagnostic: Diagnostic, analysis: Analysis, documents: Documents, positions: Positions
) -> lsp.Diagnostic:
    help_ = f"help: {diagnostic.help}" if diagnostic.help else ""
    related = [
        lsp.DiagnosticRelatedInformation(
            lsp.Location(documents.uri_of(path), positions.range(label.span)), label.text or "see here"
        )
        for label in diagnostic.secondary
        if (path := analysis.files.path_of(label.span.file)) is not None
    ]
    return lsp.Diagnostic(
        positions.range(diagnostic.primary.span),
        "\n".join(filter(None, (diagnostic.message, diagnostic.primary.text, help_))),
        _SEVERITIES[diagnostic.severity],
        diagnostic.code,
        source=SOURCE,
        tags=[lsp.DiagnosticTag.Unnecessary] if diagnostic.code in UNNECESSARY else None,
        related_information=related,
    )


def _at_imports(analysis: Analysis, documents: Documents) -> Iterator[Diagnostic]:
    """Yield the diagnostics of imported files that are not open, at their imports."""
    hidden: dict[Path, list[Diagnostic]] = {}
    for diagnostic in analysis.checked.diagnostics:
        path = analysis.files.path_of(diagnostic.primary.span.file)
        if path is not None and path != analysis.path and documents.at(path) is None:
            hidden.setdefault(path, []).append(diagnostic)
    if not hidden:
        return
    edges = {
        path: [(span, meaning.path) for span, meaning in imports(module)]
        for module in analysis.checked.sources.modules
        if (path := analysis.files.path_of(module.file)) is not None
    }
    for span, target in edges.get(analysis.path, ()):
        for path in _reached(target, edges):
            if path in hidden:
                yield _summary(span, path, hidden.pop(path))


def _reached(start: Path, edges: Mapping[Path, list[tuple[Span, Path]]]) -> list[Path]:
    """Return a file, and all its direct and indirect imports."""
    found, pending = [start], [start]
    while pending:
        for _, path in edges.get(pending.pop(), ()):
            if path not in found:
                found.append(path)
                pending.append(path)
    return found


def _summary(span: Span, path: Path, found: list[Diagnostic]) -> Diagnostic:
    """Summarize the diagnostics of a file: the first of the worst severity, and the number of others."""
    worst = min(found, key=lambda one: one.severity is not Severity.ERROR)
    more = f", and {len(found) - 1} more" if len(found) > 1 else ""
    labels = tuple(Label(one.primary.span, one.message) for one in found)
    message = f"in `{path.name}`: {worst.message}{more}"
    return Diagnostic(worst.severity, worst.code, message, Label(span, ""), labels, worst.help)
