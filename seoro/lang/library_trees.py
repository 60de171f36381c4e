"""Trees of libraries in memory: a process that loads many scenarios reads each library once."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from seoro.lang import ast
from seoro.lang.cache import parse_library
from seoro.lang.diagnostic import Bag
from seoro.lang.source import SourceFile

MAX_TREES: Final = 64  # libraries, of which a scenario imports about ten

_trees: Final[dict[Path | None, ast.OscFile]] = {}  # the first one was added first


def library_tree(file: SourceFile, bag: Bag) -> ast.OscFile:
    """Return the tree of a library; an unchanged text without errors has the tree of its last load."""
    known = _trees.get(file.path)
    if known is not None and (known.span.file.name, known.span.file.text) == (file.name, file.text):
        return known
    before = len(bag)
    tree = parse_library(file, bag)
    if len(bag) == before:
        _trees.pop(file.path, None)
        _trees[file.path] = tree
        if len(_trees) > MAX_TREES:
            _trees.pop(next(iter(_trees)), None)
    return tree
