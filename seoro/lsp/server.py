"""The server: open documents, their analyses, and published diagnostics.

The event loop answers requests from analyses, which a separate thread computes (`scheduling.py`). An exception in
a request is logged and answered with an error; the server continues.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol

from seoro import __version__
from seoro.lsp.analysis import Analysis
from seoro.lsp.documents import Document, Documents, path_of_uri
from seoro.lsp.positions import Positions
from seoro.lsp.reports import reports
from seoro.lsp.scheduling import Analyst

NAME = "seoro"
logger = logging.getLogger(__name__)


class _Protocol(LanguageServerProtocol):
    """The protocol; unreadable requests get an error reply instead of being dropped."""

    def structure_message(self, data: dict[str, Any]) -> Any:
        """Decode a message."""
        try:
            return super().structure_message(data)
        except JsonRpcException as fault:
            if "method" in data and isinstance(data.get("id"), int | str):
                self._send_response(data["id"], error=fault.to_response_error())
            raise


class SeoroServer(LanguageServer):
    """The language server; `features.py` has its requests.

    Args:
        strict: Whether to report extensions to the standard.
    """

    def __init__(self, strict: bool = False) -> None:
        # Full texts are synchronized, since the library splits lines at more characters than OSC.
        super().__init__(NAME, __version__, lsp.TextDocumentSyncKind.Full, protocol_cls=_Protocol)
        self.documents = Documents()
        self.analyst = Analyst(self.documents, self._found, strict)

    @property
    def positions(self) -> Positions:
        """Translator of positions, in the negotiated encoding."""
        return Positions(self.workspace.position_codec)

    @property
    def folders(self) -> list[Path]:
        """Folders of the editor's workspace."""
        found = (path_of_uri(folder.uri) for folder in self.workspace.folders.values())
        return [path for path in found if path is not None]

    def report_server_error(self, error: Exception, source: type[Exception]) -> None:
        """Log an exception without a pop-up in the editor."""
        logger.error("%s: %s", source.__name__, error)

    # ------------------------------------------------------------ documents

    def take(self, uri: str) -> Document | None:
        """Store the current text of a document."""
        document = self.workspace.get_text_document(uri)
        return self.documents.put(document.uri, document.version, document.source)

    def document(self, uri: str) -> Document:
        """Return an open document.

        Raises:
            JsonRpcInvalidParams: The document is not open.
        """
        document = self.documents.find(uri)
        if document is None:
            raise JsonRpcInvalidParams(f"{uri} is not an open file")
        return document

    async def analysis(self, uri: str) -> Analysis:
        """Return the analysis of an open document's current text."""
        document = self.document(uri)
        analysis = await self.analyst.current(document.path)
        assert analysis is not None, "open documents have one"
        return analysis

    # ------------------------------------------------------------ diagnostics

    def _found(self, analysis: Analysis) -> None:
        """Publish the diagnostics of an analysis in all affected documents."""
        for path in analysis.files.by_path:
            document = self.documents.at(path)
            if document is not None:
                self._report(document)

    def _report(self, document: Document) -> None:
        fresh = [analysis for analysis in self.analyst.analyses if _is_fresh(analysis, document)]
        own = next((analysis for analysis in fresh if analysis.path == document.path), None)
        if own is not None:
            others = [analysis for analysis in fresh if analysis is not own]
            found = reports(own, others, self.documents, self.positions)
            self.show(document.uri, found, document.version)

    def show(self, uri: str, found: list[lsp.Diagnostic], version: int | None = None) -> None:
        """Replace the diagnostics of a document."""
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, found, version))

    def shutdown(self) -> None:
        """Shut down without waiting for running checks."""
        self.analyst.close()
        super().shutdown()  # type: ignore[no-untyped-call]


def _is_fresh(analysis: Analysis, document: Document) -> bool:
    """Return whether an analysis has read the current text of a document."""
    file = analysis.files.by_path.get(document.path)
    return file is not None and file.text == document.text
