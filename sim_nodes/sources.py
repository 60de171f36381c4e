"""Folders that requests name, to look for files in."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from seoro.bridges.models import files_in
from seoro.input_files import resolved

FILE = "file://"


def folders_of(sources: Sequence[str]) -> tuple[list[Path], list[str]]:
    """The folders, each given by its absolute path or as `file://PATH`, and a sentence on each that is none."""
    folders = {source: Path(unquote(source.removeprefix(FILE))) for source in sources}
    unknown = [source for source, folder in folders.items() if not (folder.is_absolute() and folder.is_dir())]
    known = [resolved(folder) for source, folder in folders.items() if source not in unknown]
    return known, [f"{source!r} is no folder here" for source in unknown]


def files_of(folders: Sequence[Path], suffixes: Container[str]) -> Iterator[Path]:
    """The files in folders that have one of some suffixes, folder by folder."""
    for folder in folders:
        yield from files_in(folder, suffixes)
