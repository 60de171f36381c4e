"""Conversion of diagnostics for editors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from lsprotocol import types as lsp

from seoro.files.inputs import resolved
from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.source import Span
from seoro.lsp.analysis import Analysis
from seoro.lsp.documents import Documents
from seoro.lsp.local_names import imports
from seoro.lsp.positions import Positions

SOURCE = "seoro"
_SEVERITIES = {Severity.ERROR: lsp.DiagnosticSeverity.Error, Severity.WARNING: lsp.DiagnosticSeverity.Warning}


class Reports:
    """Creates the diagnostics of open documents.

    Args:
        documents: The open documents.
        positions: For ranges.
    """

    def __init__(self, documents: Documents, positions: Positions) -> None:
        self._documents = documents
        self._positions = positions

    def report(self, path: Path, own: Analysis, others: Iterable[Analysis]) -> list[lsp.Diagnostic]:
        """Return the diagnostics of a document.

        Errors in imported files appear there, if they are open, else at the import.

        Args:
            path: Path of the document.
            own: Its analysis.
            others: Analyses of documents that may import it.
        """
        found = [*self._found_in(path, own), *_at_imports(own, self._documents)]
        for other in others:
            found += self._found_in(path, other)
        shown: dict[tuple[object, ...], lsp.Diagnostic] = {}
        for diagnostic in found:
            span = diagnostic.primary.span
            key = (diagnostic.code, diagnostic.message, span.start, span.end)
            shown.setdefault(key, self._shown(diagnostic, own))
        return list(shown.values())

    @staticmethod
    def _found_in(path: Path, analysis: Analysis) -> Iterator[Diagnostic]:
        for diagnostic in analysis.checked.diagnostics:
            if analysis.files.path_of(diagnostic.primary.span.file) == path:
                yield diagnostic

    def _shown(self, diagnostic: Diagnostic, analysis: Analysis) -> lsp.Diagnostic:
        text = [diagnostic.message]
        text += [diagnostic.primary.text] if diagnostic.primary.text else []
        text += [f"help: {diagnostic.help}"] if diagnostic.help else []
        related = (self._related(label, analysis) for label in diagnostic.secondary)
        return lsp.Diagnostic(
            self._positions.range(diagnostic.primary.span),
            "\n".join(text),
            _SEVERITIES[diagnostic.severity],
            diagnostic.code,
            source=SOURCE,
            related_information=[found for found in related if found is not None],
        )

    def _related(self, label: Label, analysis: Analysis) -> lsp.DiagnosticRelatedInformation | None:
        path = analysis.files.path_of(label.span.file)
        if path is None:
            return None
        location = lsp.Location(self._documents.uri_of(path), self._positions.range(label.span))
        return lsp.DiagnosticRelatedInformation(location, label.text or "see here")


def _at_imports(analysis: Analysis, documents: Documents) -> Iterator[Diagnostic]:
    """Yield the diagnostics of imported files that are not open, at their imports."""
    hidden: dict[Path, list[Diagnostic]] = {}
    for diagnostic in analysis.checked.diagnostics:
        path = analysis.files.path_of(diagnostic.primary.span.file)
        if path is not None and path != analysis.path and documents.at(path) is None:
            hidden.setdefault(path, []).append(diagnostic)
    if not hidden:
        return
    edges = _imports(analysis)
    for span, target in edges.get(analysis.path, ()):
        for path in _reached(target, edges):
            if path in hidden:
                yield _summary(span, path, hidden.pop(path))


def _imports(analysis: Analysis) -> Mapping[Path, list[tuple[Span, Path]]]:
    """Return the imports of each file, with their spans."""
    edges: dict[Path, list[tuple[Span, Path]]] = {}
    for module in analysis.checked.sources.modules:
        if module.file.path is not None:
            found = [(span, meaning.path) for span, meaning in imports(module)]
            edges[resolved(module.file.path)] = found
    return edges


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
