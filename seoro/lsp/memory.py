"""What is kept of a document from one check to the next."""

from __future__ import annotations

from pathlib import Path

from seoro.lang import ast
from seoro.lang.check.recall import BodyMessages
from seoro.lang.diagnostic import Bag
from seoro.lang.pieces import IncrementalParser
from seoro.lang.source import SourceFile


class Memory:
    """Trees and messages of a document and of the files that it imports."""

    def __init__(self) -> None:
        self.bodies = BodyMessages()
        self._parsers: dict[Path | None, IncrementalParser] = {}

    def parse(self, file: SourceFile, bag: Bag) -> ast.OscFile:
        """Parse a file, with the trees of statements that have not changed."""
        return self._parsers.setdefault(file.path, IncrementalParser()).parse(file, bag)
