"""The texts that are open in the editor, which go before those on disk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias
from urllib.parse import unquote, urlsplit

from seoro.input_files import resolved
from seoro.lang.loader import Reader, Unreadable, read_file

Texts: TypeAlias = Mapping[Path, str]  # of open documents, by resolved path


@dataclass(frozen=True)
class Document:
    """An open document.

    Args:
        path: Its resolved path; that of one that was never saved exists in name only.
        uri: What the editor calls it.
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
        """Take the text of a document that was opened or changed; None if it is not one that can be checked."""
        path = path_of_uri(uri)
        if path is None:
            return None
        self._open[path] = Document(path, uri, version, text)
        return self._open[path]

    def remove(self, uri: str) -> Document | None:
        """Forget a document; None if there was none."""
        path = path_of_uri(uri)
        return self._open.pop(path, None) if path is not None else None

    def find(self, uri: str) -> Document | None:
        """The open document of a URI."""
        path = path_of_uri(uri)
        return self._open.get(path) if path is not None else None

    def at(self, path: Path) -> Document | None:
        """The open document at a resolved path."""
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
        """What to call a file towards the editor: as the editor does, if it is open."""
        document = self._open.get(path)
        return document.uri if document is not None else path.as_uri()


def path_of_uri(uri: str) -> Path | None:
    """The resolved path of a document; None if it is neither a file nor new and not saved yet."""
    try:
        parts = urlsplit(uri)
        if parts.scheme not in {"file", "untitled"} or parts.netloc not in {"", "localhost"}:
            return None
        path = unquote(parts.path)
        return Path(path if parts.scheme == "file" else f"untitled {path}").resolve() if path else None
    except (ValueError, OSError, RuntimeError):  # a host that is none, a NUL, links in a circle
        return None


def reader(texts: Texts) -> Reader:
    """Reads files as the editor shows them."""

    def read(path: Path) -> str | Unreadable:
        try:
            text = texts.get(resolved(path))
        except (ValueError, OSError, RuntimeError) as fault:
            return Unreadable(str(fault))
        return read_file(path) if text is None else text

    return read
