"""Cache between the checks of a document."""

from __future__ import annotations

from pathlib import Path

from seoro.lang import ast
from seoro.lang.cache import parse_library
from seoro.lang.check.body_cache import BodyMessages
from seoro.lang.diagnostic import Bag
from seoro.lang.incremental_parser import IncrementalParser
from seoro.lang.loader import Parse, Parsers
from seoro.lang.source import SourceFile


class CheckCache:
    """Cached trees and messages of a document and its imports."""

    def __init__(self) -> None:
        self.bodies = BodyMessages()
        self.parsers = Parsers(self._own, self._library)
        self._trees: dict[Path | None, ast.OscFile] = {}  # of files without errors
        self._parsers: dict[Path | None, IncrementalParser] = {}

    def _own(self, file: SourceFile, bag: Bag) -> ast.OscFile:
        """Parse a file, and reuse the trees of unchanged statements."""
        return self._kept(file, bag, self._parsers.setdefault(file.path, IncrementalParser()).parse)

    def _library(self, file: SourceFile, bag: Bag) -> ast.OscFile:
        """Parse a file of a library, which seldom changes."""
        return self._kept(file, bag, parse_library)

    def _kept(self, file: SourceFile, bag: Bag, parse: Parse) -> ast.OscFile:
        """Return the cached tree of an unchanged file without errors, else parse it."""
        kept = self._trees.get(file.path)
        if kept is not None and (kept.span.file.name, kept.span.file.text) == (file.name, file.text):
            return kept
        before = len(bag)
        tree = parse(file, bag)
        if len(bag) == before:
            self._trees[file.path] = tree
        return tree
