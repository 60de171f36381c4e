"""Trees of libraries, kept on disk: a library is parsed once, not at every start.

A tree is a file of data in the user's cache folder, under a name that changes with the text of the library and
with what makes trees: the files of the parser, and the classes of the nodes. What is read there has a checksum and
the form of a tree of that text, or it is parsed again. A folder that cannot be written to is no fault.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from functools import cache
from pathlib import Path
from typing import Any, Final

from seoro.lang import ast, table
from seoro.lang.diagnostic import Bag
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile, Span

MAX_SIZE = 16 * 2**20  # bytes of a tree
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
    "build_expressions.py",
    "build_types.py",
    "cache.py",
    table.TABLE.name,
)


class _TooDeepError(Exception):
    """A tree has more levels than the cache keeps."""


def parse_library(file: SourceFile, bag: Bag) -> ast.OscFile:
    """The tree of a library, from the cache if it is there; errors go to the bag, and such trees are not kept."""
    path = _path(file)
    tree = _read(path, file) if path is not None else None
    if tree is None:
        before = len(bag)
        tree = parse_file(file, bag)
        if path is not None and len(bag) == before:
            _write(path, tree)
    return tree


def _path(file: SourceFile) -> Path | None:
    """Where the tree of a text is kept; None if there is no place for it."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        digest = hashlib.sha256(f"{_form()}\n{file.text}".encode()).hexdigest()
    except (OSError, RuntimeError, UnicodeEncodeError):
        return None
    stem = file.path.stem if file.path is not None else ""
    return Path(home) / "seoro" / "trees" / f"{stem}-{digest}.json"


@cache
def _form() -> str:
    """What trees depend on besides the text."""
    classes = [f"{cls.__name__}{cls.__match_args__}" for cls in _CLASSES]
    files = [Path(__file__).with_name(name).stat() for name in _MAKERS]
    return "\n".join([*classes, *(f"{found.st_size} {found.st_mtime_ns}" for found in files)])


def _read(path: Path, file: SourceFile) -> ast.OscFile | None:
    """The tree of a file; None if there is none, or what is there is none."""
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_SIZE + 1)
        if len(data) > MAX_SIZE:
            return None
        checksum, _, content = data.partition(b"\n")
        if checksum != _checksum(content):
            return None
        tree = _decode(json.loads(content), file)
    except (OSError, ValueError, TypeError, IndexError, RecursionError):
        return None
    return tree if isinstance(tree, ast.OscFile) else None


def _write(path: Path, tree: ast.OscFile) -> None:
    """Keep a tree in the place of earlier ones of that library; readers see all of it or nothing."""
    from tempfile import mkstemp  # noqa: PLC0415 - seldom needed

    with contextlib.suppress(OSError, _TooDeepError):
        content = json.dumps(_encode(tree, 0), separators=(",", ":")).encode()
        data = _checksum(content) + b"\n" + content
        if len(data) > MAX_SIZE:
            return
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        handle, name = mkstemp(dir=path.parent)  # readable by its user only
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(data)
            Path(name).replace(path)
        except OSError:
            Path(name).unlink()
            raise
        library = _library(path)
        for other in path.parent.glob("*.json"):
            if other != path and _library(other) == library:
                other.unlink(missing_ok=True)


def _library(path: Path) -> str:
    """The library that a file in the cache belongs to."""
    return path.name.rpartition("-")[0]


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


def _encode(value: Any, depth: int) -> Any:
    """A node as the number of its class, start, end and fields; a tuple as its items.

    The limit of depth is our own, not Python's: that one is of the process, and the parser may have raised it.

    Raises:
        _TooDeepError: There are more than `MAX_DEPTH` levels.
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
    """What `_encode` was given.

    Raises:
        ValueError, TypeError, IndexError: The data are not of its making.
    """
    if type(data) is not list:
        if isinstance(data, dict):
            raise TypeError("no part of a tree")
        return data
    number = data[0]
    if number == _TUPLE:
        return tuple([_decode(item, file) for item in data[1:]])
    _, start, end, *fields = data
    if number < 0 or {type(start), type(end)} != {int} or not 0 <= start <= end <= len(file.text):
        raise ValueError("a place outside of the text")
    return _CLASSES[number](*[_decode(field, file) for field in fields], Span(file, start, end))
