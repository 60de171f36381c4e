"""Names that only the tree has: labels, parameters of methods, `as` clauses, and imported files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from seoro.files.inputs import resolved
from seoro.lang import ast
from seoro.lang.check.labels import labelled
from seoro.lang.libraries import library_file
from seoro.lang.loader import Module, path_of
from seoro.lang.source import SourceFile, Span
from seoro.lang.tree import find, walk
from seoro.lsp.meaning import ImportedFile, Label, Meaning, Occurrence

Found = Iterator[tuple[Span, Meaning]]


def local_names(tree: ast.OscFile, declared: Mapping[tuple[SourceFile, int], Meaning]) -> Found:
    """Yield the names in a file that are local to one declaration.

    Args:
        tree: The file.
        declared: Declarations by the places of their names.
    """
    for node in walk(tree):
        match node:
            case ast.DoDirective():
                yield from _labels(node)
            case ast.MethodDeclaration():
                yield from _parameters(node, declared)
            case ast.EventOccurrence(name=ast.Name() as name, condition=condition) if condition is not None:
                occurrence = Occurrence(name.text, name.span)
                yield name.span, occurrence
                for expression in find(condition, ast.NameExpression):
                    if _is_bare(expression.name, name.text):
                        yield expression.span, occurrence
            case _:
                pass


def _labels(directive: ast.DoDirective) -> Found:
    labels: dict[str, Label] = {}
    for name, member in labelled(directive.member):
        yield name.span, labels.setdefault(name.text, Label(name.text, name.span, member.body))
    for access in find(directive, ast.FieldAccess):
        match access.base:
            case ast.NameExpression(name) if name.namespace is None and name.text in labels:
                yield name.span, labels[name.text]
            case _:
                pass


def _parameters(method: ast.MethodDeclaration, declared: Mapping[tuple[SourceFile, int], Meaning]) -> Found:
    for parameter in method.parameters:
        span = parameter.name.span
        meaning = declared.get((span.file, span.start))
        if meaning is not None:
            for expression in find(method.implementation, ast.NameExpression):
                if _is_bare(expression.name, parameter.name.text):
                    yield expression.span, meaning


def _is_bare(name: ast.Name, text: str) -> bool:
    return name.namespace is None and name.text == text


def imports(module: Module) -> Iterator[tuple[Span, ImportedFile]]:
    """Yield the import statements of a file, with the imported files."""
    for statement in module.tree.statements:
        found = imported(statement, module)
        if found is not None:
            yield statement.span, found


def imported(statement: ast.Statement, module: Module) -> ImportedFile | None:
    """Return the file of an import; None for other statements, and if the file is missing."""
    path: Path | None = None
    library: str | None = None
    match statement:
        case ast.ImportModule(names):
            library = ".".join(names)
            path = library_file(library, module.file.path)
        case ast.ImportUri(uri):
            relative = path_of(uri)
            if relative is not None and module.file.path is not None:
                path = module.file.path.parent / relative
        case _:
            pass
    try:
        return ImportedFile(resolved(path), library) if path is not None else None
    except (ValueError, OSError, RuntimeError):  # a NUL, or cyclic links: the import is reported
        return None
