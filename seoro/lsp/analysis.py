"""What is known of a document: it is checked, with all that it imports, as an editor shows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from seoro.embed.scenarios import check_file
from seoro.lang import ast
from seoro.lang.check.checker import Checked
from seoro.lang.libraries import library_files
from seoro.lang.loader import Module
from seoro.lang.source import SourceFile
from seoro.lsp.documents import Texts, reader
from seoro.lsp.index import Files, Index, Notes
from seoro.lsp.memory import Memory

ENTRY = ".import-of-one-library.osc"  # stands for a scenario that imports a library, when that is what is open


@dataclass(frozen=True)
class Analysis:
    """A document that was checked.

    Args:
        path: Its resolved path.
        checked: The scenario of which it is the entry; a library that is open is imported by one of its own.
        files: The files that were read.
        module: The document itself.
        notes: What was noted while it was checked.
    """

    path: Path
    checked: Checked
    files: Files
    module: Module
    notes: Notes

    @cached_property
    def index(self) -> Index:
        """What stands where; made when it is needed, since diagnostics do not wait for it."""
        len(self.checked.behaviors)  # those that were left are checked now, which makes their notes
        return Index(self.checked, self.notes, self.files)

    @property
    def file(self) -> SourceFile:
        """The text that was checked."""
        return self.module.file

    @property
    def tree(self) -> ast.OscFile:
        """Its tree."""
        return self.module.tree

    @property
    def has_syntax_errors(self) -> bool:
        """Whether parts of the tree are missing."""
        return any(found.code.startswith("E01") for found in self.checked.sources.diagnostics)


def analyse(path: Path, texts: Texts, strict: bool = False, memory: Memory | None = None) -> Analysis:
    """Check a document.

    Args:
        path: Its resolved path.
        texts: The documents that are open.
        strict: Whether to report extensions to the standard.
        memory: What is kept from one check of the document to the next.
    """
    memory = memory or Memory()
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
    ).checked  # importing runs Python, which nobody asked for who only edits
    files = Files(checked.sources.modules)
    here = [module for module in checked.sources.modules if module.file is files.by_path.get(path)]
    module = here[0] if here else checked.sources.entry  # a library's file that has just vanished
    return Analysis(path, checked, files, module, notes)


def library_at(path: Path) -> str | None:
    """The library that a file is; None if it is a user's."""
    return _libraries().get(path)


@cache
def _libraries() -> Mapping[Path, str]:
    """The modules of libraries by the paths of their files; finding those of installed packages takes a while."""
    return {path.resolve(): name for name, path in sorted(library_files(None).items())}
