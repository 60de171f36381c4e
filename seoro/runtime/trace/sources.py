"""The source texts of a run in its trace, so that a page or a colleague can show the lines without the files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from seoro.lang.source import SourceFile

MAX_TEXT: Final = 1_000_000  # characters of all files together; larger texts are omitted
_LIBRARY: Final = Path(__file__).parents[2] / "lang" / "library"


def sources(files: Sequence[SourceFile]) -> list[dict[str, Any]]:
    """Return name, SHA-256 and text of files.

    Libraries of seoro have no text, but `library`. Texts beyond `MAX_TEXT` are omitted.

    Args:
        files: The files.
    """
    found: list[dict[str, Any]] = []
    left = MAX_TEXT
    for file in files:
        described: dict[str, Any] = {"name": file.name, "sha256": file.sha256}
        if file.path is not None and file.path.parent == _LIBRARY:
            described["library"] = True
        elif len(file.text) <= left:
            left -= len(file.text)
            described["text"] = file.text
        found.append(described)
    return found
