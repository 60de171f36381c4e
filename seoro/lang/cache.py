"""Cache of library trees on disk, so that a library is not parsed at every start.

A tree is a data file in the user's cache folder. Its name depends on the text of the library, the files of the
parser, and the classes of the nodes. Files without a valid checksum or an invalid tree are ignored. The cache is
not used if the folder is read-only.
"""

from __future__ import annotations

import contextlib
import json
from functools import cache
from pathlib import Path
from typing import Any, Final

from seoro.files.cache import cache_folder, digest_of, read_cached, stamps_of, write_cached
from seoro.lang import ast, parse_table
from seoro.lang.diagnostic import Bag
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile, Span

MAX_DEPTH = 400  # levels of a tree; a chain of operators has one for each operand
_TUPLE: Final = -1  # in the place of a class
_CLASSES: Final = tuple(
    found
    for found in vars(ast).values()
    if isinstance(found, type) and issubclass(found, ast.Node) and found is not ast.Node
)
_MAKERS: Final = (
    "lexer.py",
    "parser.py",
    "automaton.py",
    "build.py",
    "cache.py",
    parse_table.TABLE.name,
)


class _TooDeepError(Exception):
    """A tree has more levels than the cache keeps."""


def parse_library(file: SourceFile, bag: Bag) -> ast.OscFile:
    """Return the tree of a library, from the cache if possible; trees with errors are not cached."""
    path = _path(file)
    tree = _read(path, file) if path is not None else None
    if tree is None:
        before = len(bag)
        tree = parse_file(file, bag)
        if path is not None and len(bag) == before:
            _write(path, tree)
    return tree


def _path(file: SourceFile) -> Path | None:
    """Return the cache file of a text; None without a cache folder."""
    folder = cache_folder("trees")
    try:
        digest = digest_of(f"{_form()}\n{file.text}")
    except (OSError, UnicodeEncodeError):
        return None
    stem = file.path.stem if file.path is not None else ""
    return folder / f"{stem}-{digest}.json" if folder is not None else None


@cache
def _form() -> str:
    """Return the digest input besides the text."""
    classes = [f"{cls.__name__}{cls.__match_args__}" for cls in _CLASSES]
    return "\n".join([*classes, stamps_of([Path(__file__).with_name(name) for name in _MAKERS])])


def _read(path: Path, file: SourceFile) -> ast.OscFile | None:
    """Read a cached tree; None if it is missing or invalid."""
    content = read_cached(path)
    try:
        tree = _decode(json.loads(content), file) if content is not None else None
    except (ValueError, TypeError, IndexError, RecursionError):
        return None
    return tree if isinstance(tree, ast.OscFile) else None


def _write(path: Path, tree: ast.OscFile) -> None:
    """Store a tree, and delete earlier ones of that library."""
    with contextlib.suppress(OSError, _TooDeepError):
        write_cached(path, json.dumps(_encode(tree, 0), separators=(",", ":")).encode())
        library = _library(path)
        for other in path.parent.glob("*.json"):
            if other != path and _library(other) == library:
                other.unlink(missing_ok=True)


def _library(path: Path) -> str:
    """Return the library of a file in the cache."""
    return path.name.rpartition("-")[0]


def _encode(value: Any, depth: int) -> Any:
    """Encode a node as the number of its class, start, end and fields; a tuple as its items.

    The depth is limited here, as the parser may have raised Python's recursion limit.

    Raises:
        _TooDeepError: The tree has more than `MAX_DEPTH` levels.
    """
    if depth > MAX_DEPTH:
        raise _TooDeepError
    if isinstance(value, ast.Node):
        names: tuple[str, ...] = type(value).__match_args__
        *fields, span = (getattr(value, name) for name in names)  # the last one of each node
        parts = [_encode(field, depth + 1) for field in fields]
        return [_CLASSES.index(type(value)), span.start, span.end, *parts]
    return [_TUPLE, *[_encode(item, depth + 1) for item in value]] if isinstance(value, tuple) else value


def _decode(data: Any, file: SourceFile) -> Any:
    """Decode the result of `_encode`.

    Raises:
        ValueError, TypeError, IndexError: The data are invalid.
    """
    if type(data) is not list:
        if isinstance(data, dict):
            raise TypeError("invalid part of a tree")
        return data
    number = data[0]
    if number == _TUPLE:
        return tuple([_decode(item, file) for item in data[1:]])
    _, start, end, *fields = data
    if number < 0 or {type(start), type(end)} != {int} or not 0 <= start <= end <= len(file.text):
        raise ValueError("span outside of the text")
    return _CLASSES[number](*[_decode(field, file) for field in fields], Span(file, start, end))
