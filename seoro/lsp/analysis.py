"""Analysis of documents: check them with their imports, as the editor shows them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from seoro.embed.scenarios import check_file
from seoro.files.inputs import resolved
from seoro.lang import ast
from seoro.lang.check.body_cache import BodyMessages
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Bag
from seoro.lang.incremental_parser import IncrementalParser
from seoro.lang.libraries import library_files
from seoro.lang.loader import Module, Parsers, read_file
from seoro.lang.source import SourceFile
from seoro.lsp.documents import Texts, reader
from seoro.lsp.index import Files, Index, Notes

ENTRY = ".import-of-one-library.osc"  # a scenario that imports an open library
MAX_FILES = 2000  # searched in a workspace
SUFFIX = ".osc"


class CheckCache:
    """Cached trees and messages of a document and its imports."""

    def __init__(self) -> None:
        self.bodies = BodyMessages()
        self.parsers = Parsers(self._own)
        self._trees: dict[Path | None, ast.OscFile] = {}  # of files without errors
        self._parsers: dict[Path | None, IncrementalParser] = {}

    def _own(self, file: SourceFile, bag: Bag) -> ast.OscFile:
        """Return the cached tree of an unchanged file without errors, else parse it.

        The trees of unchanged statements are reused.
        """
        kept = self._trees.get(file.path)
        if kept is not None and (kept.span.file.name, kept.span.file.text) == (file.name, file.text):
            return kept
        before = len(bag)
        tree = self._parsers.setdefault(file.path, IncrementalParser()).parse(file, bag)
        if len(bag) == before:
            self._trees[file.path] = tree
        return tree


@dataclass(frozen=True)
class Analysis:
    """A checked document.

    Args:
        path: Its resolved path.
        checked: The scenario whose entry it is; for a library, a scenario that imports it.
        files: The files that were read.
        module: The document itself.
        notes: Records of the check.
    """

    path: Path
    checked: Checked
    files: Files
    module: Module
    notes: Notes

    @cached_property
    def index(self) -> Index:
        """Index of names and types; built on demand, so that diagnostics do not wait for it."""
        len(self.checked.behaviors)  # elaborates deferred behaviors, which completes the notes
        return Index(self.checked, self.notes, self.files)

    @property
    def file(self) -> SourceFile:
        """The checked text."""
        return self.module.file

    @property
    def tree(self) -> ast.OscFile:
        """Its tree."""
        return self.module.tree

    @property
    def has_syntax_errors(self) -> bool:
        """Whether parts of the tree are missing."""
        return any(found.code.startswith("E01") for found in self.checked.sources.diagnostics)


def analyse(path: Path, texts: Texts, strict: bool = False, memory: CheckCache | None = None) -> Analysis:
    """Check a document.

    Args:
        path: Its resolved path.
        texts: The open documents.
        strict: Whether to report extensions to the standard.
        memory: Cache between checks of the document.
    """
    memory = memory or CheckCache()
    notes = Notes()
    library = library_at(path)
    entry = path
    if library is not None:
        entry = path.with_name(ENTRY)
        texts = {**texts, entry: f"import {library}\n"}
    checked = check_file(
        entry,
        strict=strict,
        import_python=False,
        read=reader(texts),
        recorder=notes,
        parsers=memory.parsers,
        known=memory.bodies,
    ).checked  # editing must not import, as that runs Python
    files = Files(checked.sources.modules)
    here = [module for module in checked.sources.modules if module.file is files.by_path.get(path)]
    module = here[0] if here else checked.sources.entry  # a library's file that has just vanished
    return Analysis(path, checked, files, module, notes)


def library_at(path: Path) -> str | None:
    """Return the name of the library in a file; None for files of users."""
    return _libraries().get(path)


@cache
def _libraries() -> Mapping[Path, str]:
    """Return the libraries by their files; cached, as searching installed packages is slow."""
    return {path.resolve(): name for name, path in sorted(library_files(None).items())}


def files_with(words: Sequence[str], folders: Iterable[Path]) -> Iterator[Path]:
    """Yield the scenario files that contain one of the words, without hidden folders."""
    seen = 0
    for folder in folders:
        for where, below, names in os.walk(folder):
            below[:] = sorted(name for name in below if not name.startswith("."))
            for name in sorted(names):
                if not name.endswith(SUFFIX):
                    continue
                seen += 1
                if seen > MAX_FILES:
                    return
                path = Path(where, name)
                text = read_file(path)
                if isinstance(text, str) and any(word in text for word in words):
                    yield resolved(path)


def analyse_users(
    words: Sequence[str], folders: Iterable[Path], texts: Texts, known: Iterable[Analysis]
) -> list[Analysis]:
    """Analyse files of the workspace that may use one of the names and are in no known analysis."""
    found = list(known)
    seen = {path for analysis in found for path in analysis.files.by_path}
    for path in files_with(words, folders):
        if path not in seen:
            analysis = analyse(path, texts)
            found.append(analysis)
            seen |= analysis.files.by_path.keys()
    return found
