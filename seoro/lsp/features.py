"""Handlers of the server's requests and notifications."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException

from seoro.errors import InvalidScenario
from seoro.lang.format.formatter import format_text
from seoro.lang.source import SourceFile, Span
from seoro.lsp import navigation
from seoro.lsp.analysis import Analysis, analyse_users
from seoro.lsp.completion import complete
from seoro.lsp.hover import hover
from seoro.lsp.items import Item
from seoro.lsp.meaning import name_of
from seoro.lsp.outline import Outline, declared, folds, kind_of
from seoro.lsp.rename_check import check_collisions
from seoro.lsp.reports import fixes
from seoro.lsp.server import SeoroServer
from seoro.lsp.signatures import signature_at

SUFFIXES = "**/*.osc"


def make_server(strict: bool = False) -> SeoroServer:
    """Create a server with all features.

    Args:
        strict: Whether to report extensions to the standard.
    """
    server = SeoroServer(strict)
    _follow_texts(server)
    _answer_about_names(server)
    _answer_while_writing(server)
    _answer_about_files(server)
    return server


def _follow_texts(server: SeoroServer) -> None:
    """Handle notifications about documents and files."""

    @server.feature(lsp.INITIALIZED)
    async def initialized(_: lsp.InitializedParams) -> None:
        await _watch_files(server)

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def did_open(params: lsp.DidOpenTextDocumentParams) -> None:
        if server.take(params.text_document.uri) is not None:
            server.analyst.changed_all()

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def did_change(params: lsp.DidChangeTextDocumentParams) -> None:
        document = server.take(params.text_document.uri)
        if document is not None:
            server.analyst.changed(document.path)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def did_close(params: lsp.DidCloseTextDocumentParams) -> None:
        if server.documents.remove(params.text_document.uri) is not None:
            server.show(params.text_document.uri, [])
            server.analyst.changed_all()

    @server.feature(lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def did_change_files(_: lsp.DidChangeWatchedFilesParams) -> None:
        server.analyst.changed_all()


async def _watch_files(server: SeoroServer) -> None:
    """Subscribe to changes of files outside of the editor, if the editor supports it."""
    workspace = server.client_capabilities.workspace
    watching = workspace.did_change_watched_files if workspace is not None else None
    if watching is not None and watching.dynamic_registration:
        options = lsp.DidChangeWatchedFilesRegistrationOptions([lsp.FileSystemWatcher(SUFFIXES)])
        registration = lsp.Registration("watch", lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES, options)
        await server.client_register_capability_async(lsp.RegistrationParams([registration]))


def _answer_about_names(server: SeoroServer) -> None:
    """Handle requests about names: hover, definition, references, rename."""

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    async def on_hover(params: lsp.HoverParams) -> lsp.Hover | None:
        analysis, offset = await _place(server, params)
        found = hover(analysis, offset)
        if found is None:
            return None
        text, span = found
        return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, text), server.positions.range(span))

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    async def on_definition(params: lsp.DefinitionParams) -> lsp.Location | None:
        analysis, offset = await _place(server, params)
        found = navigation.declared_at(analysis, offset)
        return _location(server, *found) if found is not None else None

    @server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    async def on_references(params: lsp.ReferenceParams) -> list[lsp.Location]:
        analysis, offset = await _place(server, params)
        found = navigation.target_at(analysis, offset)
        if found is None:
            return []
        use, target = found
        users = await _users(server, name_of(use.meaning))
        declared = navigation.family(target, users)
        return [
            _location(server, path, span)
            for path, spans in navigation.uses(declared, users).items()
            for span in spans
            if params.context.include_declaration or (path, span.start, span.end) not in declared
        ]

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
    async def on_highlight(params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
        analysis, offset = await _place(server, params)
        found = navigation.target_at(analysis, offset)
        if found is None:
            return []
        spans = navigation.uses(navigation.family(found[1], [analysis]), [analysis]).get(analysis.path, [])
        return [lsp.DocumentHighlight(server.positions.range(span)) for span in spans]

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    async def on_prepare_rename(params: lsp.PrepareRenameParams) -> lsp.Range | None:
        analysis, offset = await _place(server, params)
        try:
            _, span, _ = navigation.check_rename(analysis, offset)
        except navigation.CannotRename:
            return None
        return server.positions.range(span)

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    async def on_rename(params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        analysis, offset = await _place(server, params)
        try:
            name, _, target = navigation.check_rename(analysis, offset)
            new = params.new_name
            users = await _users(server, name, new)
            edits = navigation.edits(target, name, new, users)
            texts = server.documents.texts
            await server.analyst.run(lambda: check_collisions(edits, new, users, texts))
        except navigation.CannotRename as reason:
            raise _refusal(str(reason)) from None
        return lsp.WorkspaceEdit(
            {
                server.documents.uri_of(path): [lsp.TextEdit(server.positions.range(span), new) for span in spans]
                for path, spans in edits.items()
            }
        )


def _answer_while_writing(server: SeoroServer) -> None:
    """Handle completion and signature help."""

    @server.feature(lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[".", "@", "!", "("]))
    async def on_completion(params: lsp.CompletionParams) -> list[lsp.CompletionItem]:
        document = server.document(params.text_document.uri)
        file = SourceFile(document.uri, document.text)
        offset = server.positions.offset(file, params.position)
        analyses = await server.analyst.recent(document.path)
        found = complete(document.text, offset, analyses) if analyses else None
        if found is None:
            return []
        where = server.positions.range(Span(file, found.start, offset))
        return [_completion_item(item, where) for item in found.items]

    @server.feature(lsp.TEXT_DOCUMENT_SIGNATURE_HELP, lsp.SignatureHelpOptions(trigger_characters=["(", ","]))
    async def on_signature(params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
        document = server.document(params.text_document.uri)
        offset = server.positions.offset(SourceFile(document.uri, document.text), params.position)
        analyses = await server.analyst.recent(document.path)
        found = signature_at(document.text, offset, analyses) if analyses else None
        return lsp.SignatureHelp([found], 0, found.active_parameter) if found is not None else None


def _answer_about_files(server: SeoroServer) -> None:
    """Handle requests about files: symbols, folds, formatting."""

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    async def on_symbols(params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        analysis = await server.analysis(params.text_document.uri)
        return Outline(server.positions).symbols(analysis.tree.statements)

    @server.feature(lsp.TEXT_DOCUMENT_FOLDING_RANGE)
    async def on_folds(params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
        return folds((await server.analysis(params.text_document.uri)).tree)

    @server.feature(lsp.WORKSPACE_SYMBOL)
    async def on_workspace_symbols(params: lsp.WorkspaceSymbolParams) -> list[lsp.WorkspaceSymbol]:
        found = declared(params.query, await server.analyst.all_current())
        return [
            lsp.WorkspaceSymbol(_location(server, path, span), name_of(meaning), kind_of(meaning))
            for meaning, path, span in found
        ]

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    async def on_formatting(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        document = server.document(params.text_document.uri)
        file = SourceFile(document.uri, document.text, document.path)
        try:
            text = await server.analyst.run(lambda: format_text(file))
        except InvalidScenario as invalid:
            raise _refusal(f"it has errors: {invalid.diagnostics[0].message}") from None
        whole = Span(file, 0, len(file.text))
        return [lsp.TextEdit(server.positions.range(whole), text)] if text != file.text else []

    @server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix]))
    async def on_code_action(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        analysis = await server.analysis(params.text_document.uri)
        first, last = params.range.start.line, params.range.end.line
        return [
            lsp.CodeAction(
                f"Fix {found.code}: {found.message}",
                lsp.CodeActionKind.QuickFix,
                edit=lsp.WorkspaceEdit(
                    {params.text_document.uri: [lsp.TextEdit(server.positions.range(section), "")]}
                ),
            )
            for found, section in fixes(analysis)
            if first <= found.primary.span.line - 1 <= last
        ]


# ---------------------------------------------------------------- shared


class _Positioned(Protocol):
    """Parameters of a request about a place in a document."""

    text_document: lsp.TextDocumentIdentifier
    position: lsp.Position


async def _place(server: SeoroServer, params: _Positioned) -> tuple[Analysis, int]:
    """Return the analysis of a request's document, and the offset of its position."""
    analysis = await server.analysis(params.text_document.uri)
    return analysis, server.positions.offset(analysis.file, params.position)


def _location(server: SeoroServer, path: Path, span: Span) -> lsp.Location:
    return lsp.Location(server.documents.uri_of(path), server.positions.range(span))


async def _users(server: SeoroServer, *names: str) -> Sequence[Analysis]:
    """Return the analyses of all documents, and of other workspace files that contain one of the names."""
    known = await server.analyst.all_current()
    texts, folders = server.documents.texts, server.folders
    return await server.analyst.run(lambda: analyse_users(names, folders, texts, known))


def _refusal(reason: str) -> JsonRpcException:
    """Create an error reply, which the editor shows."""
    return JsonRpcException(reason, lsp.LSPErrorCodes.RequestFailed.value)


def _completion_item(item: Item, where: lsp.Range) -> lsp.CompletionItem:
    return lsp.CompletionItem(
        item.label,
        kind=item.sort,
        detail=item.detail or None,
        documentation=item.documentation or None,
        sort_text=f"{item.rank}{item.label}",
        filter_text=item.label,
        text_edit=lsp.TextEdit(where, item.label if item.insert is None else item.insert),
    )
