"""The server: what is open, what is known of it, and what editors are told unasked.

Requests are answered on the event loop, from analyses that a thread of its own makes (`scheduling.py`). A fault in
one of them is logged and answered with an error, and the server lives on.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol
from pygls.workspace import TextDocument

from seoro import __version__
from seoro.lsp.analysis import Analysis
from seoro.lsp.documents import Document, Documents, path_of_uri
from seoro.lsp.positions import Positions
from seoro.lsp.reports import Reports
from seoro.lsp.scheduling import Analyst

NAME = "seoro"
logger = logging.getLogger(__name__)


class _Protocol(LanguageServerProtocol):
    """The protocol; a request that cannot be read is answered, too, instead of being dropped."""

    def structure_message(self, data: dict[str, Any]) -> Any:
        """What a message says."""
        try:
            return super().structure_message(data)
        except JsonRpcException as fault:
            if "method" in data and isinstance(data.get("id"), int | str):
                self._send_response(data["id"], error=fault.to_response_error())
            raise


class SeoroServer(LanguageServer):
    """The language server; `features.py` says what it answers.

    Args:
        strict: Whether to report extensions to the standard.
    """

    def __init__(self, strict: bool = False) -> None:
        # Whole texts are sent, since the library would cut lines at characters that end none here.
        super().__init__(NAME, __version__, lsp.TextDocumentSyncKind.Full, protocol_cls=_Protocol)
        self.documents = Documents()
        self.analyst = Analyst(self.documents, self._found, strict)

    @property
    def positions(self) -> Positions:
        """Translates positions, in the encoding that was agreed on."""
        return Positions(str(getattr(self.workspace.position_encoding, "value", self.workspace.position_encoding)))

    @property
    def folders(self) -> list[Path]:
        """The folders that the editor has open."""
        found = (path_of_uri(folder.uri) for folder in self.workspace.folders.values())
        return [path for path in found if path is not None]

    def report_server_error(self, error: Exception, source: type[Exception]) -> None:
        """Log what went wrong; nobody is to be interrupted by it."""
        logger.error("%s: %s", source.__name__, error)

    # ------------------------------------------------------------ documents

    def take(self, document: TextDocument) -> Document | None:
        """Take the text of a document as it is now."""
        return self.documents.put(document.uri, document.version, document.source)

    def document(self, uri: str) -> Document:
        """An open document.

        Raises:
            JsonRpcInvalidParams: There is none.
        """
        document = self.documents.find(uri)
        if document is None:
            raise JsonRpcInvalidParams(f"{uri} is not open, or not a file")
        return document

    async def analysis(self, uri: str) -> Analysis:
        """The analysis of an open document as it is now."""
        document = self.document(uri)
        analysis = await self.analyst.current(document.path)
        assert analysis is not None, "open documents have one"
        return analysis

    # ------------------------------------------------------------ diagnostics

    def _found(self, analysis: Analysis) -> None:
        """Report what was found, in all documents that it may concern."""
        for path in analysis.files.by_path:
            document = self.documents.at(path)
            if document is not None:
                self._report(document)

    def _report(self, document: Document) -> None:
        fresh = [analysis for analysis in self.analyst.analyses if _is_fresh(analysis, document)]
        own = next((analysis for analysis in fresh if analysis.path == document.path), None)
        if own is not None:
            reports = Reports(self.documents, self.positions)
            found = reports.report(document.path, own, [analysis for analysis in fresh if analysis is not own])
            self.show(document.uri, found, document.version)

    def show(self, uri: str, found: list[lsp.Diagnostic], version: int | None = None) -> None:
        """Show diagnostics in a document, in the place of those shown before."""
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, found, version))

    def shutdown(self) -> None:
        """End: of what is being checked, nothing is awaited."""
        self.analyst.close()
        super().shutdown()  # type: ignore[no-untyped-call]


def _is_fresh(analysis: Analysis, document: Document) -> bool:
    """Whether an analysis has read the text of a document as it is."""
    file = analysis.files.by_path.get(document.path)
    return file is not None and file.text == document.text
