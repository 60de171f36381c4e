"""Outline and folding ranges of a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path

from lsprotocol.types import DocumentSymbol, FoldingRange, FoldingRangeKind, SymbolKind

from seoro.lang import ast
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import EnumSymbol, EventSymbol, FieldSymbol, MethodSymbol, TypeSymbol
from seoro.lang.tree import walk
from seoro.lsp.analysis import Analysis, library_at
from seoro.lsp.items import SORTS
from seoro.lsp.meaning import Meaning, declarations, definition, name_of
from seoro.lsp.positions import Positions

_KINDS = {
    ast.StructDeclaration: SymbolKind.Struct,
    ast.ActorDeclaration: SymbolKind.Class,
    ast.ScenarioDeclaration: SymbolKind.Function,
    ast.ActionDeclaration: SymbolKind.Function,
    ast.ModifierDeclaration: SymbolKind.Operator,
    ast.StructuredTypeExtension: SymbolKind.Namespace,
    ast.EnumDeclaration: SymbolKind.Enum,
    ast.EnumTypeExtension: SymbolKind.Enum,
    ast.EnumMemberDecl: SymbolKind.EnumMember,
    ast.PhysicalTypeDeclaration: SymbolKind.TypeParameter,
    ast.EventDeclaration: SymbolKind.Event,
    ast.MethodDeclaration: SymbolKind.Method,
}
_EXTENSIONS = ast.StructuredTypeExtension | ast.PrimitiveTypeExtension | ast.EnumTypeExtension
_FOLDED = (
    ast.StructuredTypeDeclaration
    | ast.StructuredTypeExtension
    | ast.PrimitiveTypeExtension
    | ast.EnumDeclaration
    | ast.DoMember
    | ast.Composition
    | ast.FunctionApplication
)

MAX_FOUND = 500  # symbols per query


class Outline:
    """Creates the symbols of declarations.

    Args:
        positions: For ranges.
    """

    def __init__(self, positions: Positions) -> None:
        self._positions = positions

    def symbols(self, nodes: Iterable[ast.Node]) -> list[DocumentSymbol]:
        """Return the symbols of nodes, with those of their members."""
        return [symbol for node in nodes for symbol in self._symbols(node)]

    def _symbols(self, node: ast.Node) -> Iterator[DocumentSymbol]:
        extend = "extend" if isinstance(node, _EXTENSIONS) else ""
        match node:
            case (
                ast.StructDeclaration()
                | ast.ActorDeclaration()
                | ast.ScenarioDeclaration()
                | ast.ActionDeclaration()
                | ast.ModifierDeclaration()
                | ast.StructuredTypeExtension()
                | ast.EnumDeclaration()
                | ast.EnumTypeExtension()
            ):
                yield self._symbol(node, node.name.span, _KINDS[type(node)], extend, node.members)
            case ast.PrimitiveTypeExtension(type_, methods):
                yield self._symbol(node, type_.span, SymbolKind.Namespace, extend, methods)
            case (
                ast.EnumMemberDecl(name)
                | ast.PhysicalTypeDeclaration(name)
                | ast.EventDeclaration(name)
                | ast.MethodDeclaration(name)
            ):
                yield self._symbol(node, name.span, _KINDS[type(node)])
            case ast.UnitDeclaration(name, quantity):
                yield self._symbol(node, name.span, SymbolKind.Constant, quantity.text)
            case ast.GlobalParameterDeclaration(parameter):
                yield from self._fields(parameter, SymbolKind.Variable)
            case ast.ParameterDeclaration():
                yield from self._fields(node, SymbolKind.Field)
            case ast.VariableDeclaration():
                yield from self._fields(node, SymbolKind.Variable)
            case ast.DoDirective(ast.DoMember(label=None) as member):
                head = Span(node.span.file, member.span.start, member.span.start)
                yield self._symbol(member, head, SymbolKind.Function, *_composition(member), "do")
            case ast.DoDirective(member):
                yield from self._symbols(member)
            case ast.DoMember(label=None):
                yield from self.symbols(_composition(node)[1])
            case ast.DoMember(ast.Name() as label):
                yield self._symbol(node, label.span, SymbolKind.Key, *_composition(node))
            case _:
                pass

    def _fields(
        self, node: ast.ParameterDeclaration | ast.VariableDeclaration, kind: SymbolKind
    ) -> Iterator[DocumentSymbol]:
        return (self._symbol(node, name.span, kind, node.type.span.text) for name in node.names)

    def _symbol(
        self,
        node: ast.Node,
        name: Span,
        kind: SymbolKind,
        detail: str = "",
        children: Iterable[ast.Node] = (),
        shown: str = "",
    ) -> DocumentSymbol:
        whole: Span = node.span  # type: ignore[attr-defined]
        return DocumentSymbol(
            name=shown or name.text or "?",
            kind=kind,
            range=self._positions.range(whole),
            selection_range=self._positions.range(name),
            detail=detail or None,
            children=self.symbols(children),
        )


def _composition(member: ast.DoMember) -> tuple[str, tuple[ast.DoMember, ...]]:
    """Return the operator and the members of a composition; both empty for other behaviors."""
    return (member.body.operator, member.body.members) if isinstance(member.body, ast.Composition) else ("", ())


def folds(tree: ast.OscFile) -> list[FoldingRange]:
    """Return the blocks of several lines, and runs of comments."""
    file = tree.span.file
    found: dict[int, int] = {}
    for node in walk(tree):
        if isinstance(node, _FOLDED):
            first, last = node.span.line, file.position(node.span.end)[0]
            if last > first:
                found[first] = max(last, found.get(first, 0))
    ranges = [FoldingRange(first - 1, last - 1) for first, last in sorted(found.items())]
    return [*ranges, *_comments(file)]


def _comments(file: SourceFile) -> Iterator[FoldingRange]:
    numbers = range(1, file.line_count + 1)
    for is_comment, run in groupby(numbers, key=lambda number: file.line(number).lstrip().startswith("#")):
        lines = list(run)
        if is_comment and len(lines) > 1:
            yield FoldingRange(lines[0] - 1, lines[-1] - 1, kind=FoldingRangeKind.Comment)


def declared(query: str, analyses: Iterable[Analysis]) -> list[tuple[Meaning, Path, Span]]:
    """Return declarations of users whose names contain `query`, in any case; shortest names first."""
    found: dict[tuple[Path, int], tuple[Meaning, Path, Span]] = {}
    for analysis in analyses:
        for meaning in declarations(analysis.checked.program):
            span = definition(meaning) if query.casefold() in name_of(meaning).casefold() else None
            path = analysis.files.path_of(span.file) if span is not None else None
            if span is not None and path is not None and library_at(path) is None:
                found[path, span.start] = meaning, path, span
    return sorted(found.values(), key=lambda one: (len(name_of(one[0])), str(one[1]), one[2].start))[:MAX_FOUND]


def kind_of(meaning: Meaning) -> SymbolKind:
    """Return the kind of a declaration in outlines."""
    match meaning:
        case TypeSymbol(kind=kind):
            return SymbolKind[SORTS[kind].name]
        case FieldSymbol():
            return SymbolKind.Field
        case EventSymbol():
            return SymbolKind.Event
        case MethodSymbol():
            return SymbolKind.Method
        case EnumSymbol():
            return SymbolKind.Enum
        case _:
            return SymbolKind.Constant
