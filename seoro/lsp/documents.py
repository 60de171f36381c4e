"""Open documents of the editor, which take precedence over files on disk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias
from urllib.parse import unquote, urlsplit

from seoro.files.inputs import resolved
from seoro.lang.loader import Reader, Unreadable, read_file

Texts: TypeAlias = Mapping[Path, str]  # of open documents, by resolved path


@dataclass(frozen=True)
class Document:
    """An open document.

    Args:
        path: Its resolved path; the file is missing if the document was never saved.
        uri: Its URI in the editor.
        version: The editor's number of this state of the text.
        text: Its text.
    """

    path: Path
    uri: str
    version: int | None
    text: str


class Documents:
    """All open documents."""

    def __init__(self) -> None:
        self._open: dict[Path, Document] = {}

    def put(self, uri: str, version: int | None, text: str) -> Document | None:
        """Store the text of an opened or changed document; None if it cannot be checked."""
        path = path_of_uri(uri)
        if path is None:
            return None
        self._open[path] = Document(path, uri, version, text)
        return self._open[path]

    def remove(self, uri: str) -> Document | None:
        """Remove and return a document; None if it is not open."""
        path = path_of_uri(uri)
        return self._open.pop(path, None) if path is not None else None

    def find(self, uri: str) -> Document | None:
        """Return the open document of a URI."""
        path = path_of_uri(uri)
        return self._open.get(path) if path is not None else None

    def at(self, path: Path) -> Document | None:
        """Return the open document at a resolved path."""
        return self._open.get(path)

    @property
    def paths(self) -> tuple[Path, ...]:
        """The paths of all open documents."""
        return tuple(self._open)

    @property
    def texts(self) -> Texts:
        """The texts of all open documents, as they are now."""
        return MappingProxyType({path: document.text for path, document in self._open.items()})

    def uri_of(self, path: Path) -> str:
        """Return the URI of a file; for an open document, that of the editor."""
        document = self._open.get(path)
        return document.uri if document is not None else path.as_uri()


def path_of_uri(uri: str) -> Path | None:
    """Return the resolved path of a saved or new document; None for other URIs."""
    try:
        parts = urlsplit(uri)
        if parts.scheme not in {"file", "untitled"} or parts.netloc not in {"", "localhost"}:
            return None
        path = unquote(parts.path)
        return Path(path if parts.scheme == "file" else f"untitled {path}").resolve() if path else None
    except (ValueError, OSError, RuntimeError):  # an invalid host, a NUL, cyclic links
        return None


def reader(texts: Texts) -> Reader:
    """Create a reader that prefers open documents."""

    def read(path: Path) -> str | Unreadable:
        try:
            text = texts.get(resolved(path))
        except (ValueError, OSError, RuntimeError) as fault:
            return Unreadable(str(fault))
        return read_file(path) if text is None else text

    return read
