"""Outline and folding ranges of a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
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
    ast.PrimitiveTypeExtension: SymbolKind.Namespace,
}
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
    """Creates the outline of a file.

    Args:
        tree: The file.
        positions: For ranges.
    """

    def __init__(self, tree: ast.OscFile, positions: Positions) -> None:
        self._tree = tree
        self._positions = positions

    def symbols(self) -> list[DocumentSymbol]:
        """Return the declarations with their members."""
        return [symbol for statement in self._tree.statements for symbol in self._statement(statement)]

    def _statement(self, node: ast.Statement) -> Iterator[DocumentSymbol]:
        match node:
            case (
                ast.StructDeclaration()
                | ast.ActorDeclaration()
                | ast.ScenarioDeclaration()
                | ast.ActionDeclaration()
                | ast.ModifierDeclaration()
                | ast.StructuredTypeExtension()
            ):
                members = [symbol for member in node.members for symbol in self._member(member)]
                is_extension = isinstance(node, ast.StructuredTypeExtension)
                detail = "extend" if is_extension else ""
                yield self._symbol(node, node.name.span, _KINDS[type(node)], detail, members)
            case ast.PrimitiveTypeExtension(type_, methods):
                members = [symbol for member in methods for symbol in self._member(member)]
                yield self._symbol(node, type_.span, _KINDS[type(node)], "extend", members)
            case ast.EnumDeclaration(name, values) | ast.EnumTypeExtension(name, values):
                members = [self._symbol(value, value.name.span, SymbolKind.EnumMember) for value in values]
                detail = "extend" if isinstance(node, ast.EnumTypeExtension) else ""
                yield self._symbol(node, name.span, SymbolKind.Enum, detail, members)
            case ast.PhysicalTypeDeclaration(name):
                yield self._symbol(node, name.span, SymbolKind.TypeParameter)
            case ast.UnitDeclaration(name, quantity):
                yield self._symbol(node, name.span, SymbolKind.Constant, quantity.text)
            case ast.GlobalParameterDeclaration(parameter):
                yield from self._fields(parameter, SymbolKind.Variable)
            case _:
                pass

    def _member(self, node: ast.TypeMember) -> Iterator[DocumentSymbol]:
        match node:
            case ast.ParameterDeclaration():
                yield from self._fields(node, SymbolKind.Field)
            case ast.VariableDeclaration():
                yield from self._fields(node, SymbolKind.Variable)
            case ast.EventDeclaration(name):
                yield self._symbol(node, name.span, SymbolKind.Event)
            case ast.MethodDeclaration(name):
                yield self._symbol(node, name.span, SymbolKind.Method)
            case ast.DoDirective(member):
                yield from self._behavior(member, "do")
            case _:
                pass

    def _fields(
        self, node: ast.ParameterDeclaration | ast.VariableDeclaration, kind: SymbolKind
    ) -> Iterator[DocumentSymbol]:
        return (self._symbol(node, name.span, kind, node.type.span.text) for name in node.names)

    def _behavior(self, member: ast.DoMember, otherwise: str = "") -> Iterator[DocumentSymbol]:
        """Yield the behavior of a `do`, with its labelled behaviors nested in each other."""
        body = member.body
        inner: list[DocumentSymbol] = []
        if isinstance(body, ast.Composition):
            inner = [symbol for part in body.members for symbol in self._behavior(part)]
        detail = body.operator if isinstance(body, ast.Composition) else ""
        if member.label is not None:
            yield self._symbol(member, member.label.span, SymbolKind.Key, detail, inner)
        elif otherwise:
            head = Span(body.span.file, member.span.start, member.span.start)
            yield self._symbol(member, head, SymbolKind.Function, detail, inner, otherwise)
        else:
            yield from inner

    def _symbol(
        self,
        node: ast.Node,
        name: Span,
        kind: SymbolKind,
        detail: str = "",
        children: list[DocumentSymbol] | None = None,
        shown: str = "",
    ) -> DocumentSymbol:
        whole: Span = node.span  # type: ignore[attr-defined]
        return DocumentSymbol(
            name=shown or name.text or "?",
            kind=kind,
            range=self._positions.range(whole),
            selection_range=self._positions.range(name),
            detail=detail or None,
            children=children or [],
        )


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
    first: int | None = None
    for number in range(1, file.line_count + 2):
        is_comment = number <= file.line_count and file.line(number).lstrip().startswith("#")
        if is_comment and first is None:
            first = number
        elif not is_comment and first is not None:
            if number - 1 > first:
                yield FoldingRange(first - 1, number - 2, kind=FoldingRangeKind.Comment)
            first = None


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
