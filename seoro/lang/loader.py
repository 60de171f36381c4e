"""Loader: reads the entry file of a scenario and its imports (7.7.5).

Each file is read once, at its first place in a depth-first walk; cyclic imports are valid. A module `osc.<name>`
is a library, which `libraries.py` finds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from pathlib import Path
from typing import Final, NamedTuple, TypeAlias
from urllib.parse import unquote, urlsplit

from seoro.deferred import dataclass
from seoro.errors import InvalidScenario
from seoro.files.inputs import Kind, read_input, resolved
from seoro.files.path_mapping import Locate, unchanged_path
from seoro.lang import ast
from seoro.lang.builtin_libraries import STANDARD_MODULES
from seoro.lang.diagnostic import Bag, Diagnostic
from seoro.lang.diagnostics import imports, syntax
from seoro.lang.frozen import Value
from seoro.lang.libraries import Library, find_library
from seoro.lang.library_trees import library_tree
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile, Span

MAX_MISSES = 30  # failed imports before loading stops
MAX_PATH = 4096  # characters


class Unreadable(Value):
    """Reason why a file could not be read."""

    reason: str


def read_file(path: Path) -> str | Unreadable:
    """Read the text of a file on disk."""
    try:
        data = read_input(path, Kind.SCENARIO)
    except OSError as fault:
        return Unreadable(fault.strerror or str(fault))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        return Unreadable(f"not UTF-8 (byte {fault.start})")


Reader: TypeAlias = Callable[[Path], str | Unreadable]
Parse: TypeAlias = Callable[[SourceFile, Bag], ast.OscFile]


class Parsers(NamedTuple):
    """Parsers for files of users, and for libraries."""

    own: Parse = parse_file
    library: Parse = library_tree


PARSERS: Final = Parsers()


class Module(Value):
    """A loaded file.

    Args:
        file: Its text.
        tree: Its tree; empty if nothing could be parsed.
        library: Imported library, such as `osc.nav2`; None for files of the user.
    """

    file: SourceFile
    tree: ast.OscFile
    library: str | None


class Sources(Value):
    """A scenario file with its imports.

    Args:
        entry: The scenario file.
        modules: All files, imported ones before their importers.
        uses: Namespaces that imports use for the global one.
        libraries: The libraries, in the order of imports.
        diagnostics: Errors of the texts.
        unread: Names that unreadable text may declare; None for any name.
    """

    entry: Module
    modules: tuple[Module, ...]
    uses: frozenset[str]
    libraries: tuple[Library, ...]
    diagnostics: tuple[Diagnostic, ...]
    unread: frozenset[str] | None


@dataclass(eq=False)
class _Loading:
    """State of one walk over the imports."""

    entry: SourceFile
    read: Reader
    locate: Locate
    parsers: Parsers
    bag: Bag = field(default_factory=Bag)
    seen: set[Path] = field(default_factory=set)
    modules: list[Module] = field(default_factory=list)
    uses: set[str] = field(default_factory=set)
    libraries: dict[str, Library] = field(default_factory=dict)
    missed: int = 0

    def miss(self, message: Diagnostic) -> None:
        """Report a failed import."""
        self.missed += 1
        self.bag.put(message)


def load(
    path: Path,
    name: str | None = None,
    read: Reader = read_file,
    locate: Locate = unchanged_path,
    parsers: Parsers = PARSERS,
) -> Sources:
    """Read and parse a scenario file and its imports.

    Errors in the texts do not raise; they are in the `diagnostics` of the result.

    Args:
        path: The file.
        name: Name of the file in messages; default `path`.
        read: Reader of files.
        locate: Maps absolute paths of imports.
        parsers: Parsers of the files.
    """
    shown = name or str(path)
    text = read(path)
    file = SourceFile(shown, text if isinstance(text, str) else "", path)
    loading = _Loading(file, read, locate, parsers)
    if not isinstance(text, str):
        loading.miss(syntax.unreadable_file(Span(file, 0, 0), shown, text.reason))
    entry = _load(loading, file, path, None)
    return Sources(
        entry,
        tuple(loading.modules),
        frozenset(loading.uses),
        tuple(loading.libraries.values()),
        tuple(sorted(loading.bag.diagnostics, key=lambda found: found.position)),
        _unread(loading),
    )


def _unread(loading: _Loading) -> frozenset[str] | None:
    """Return names that unreadable text may declare; None if a whole file is missing."""
    names: set[str] = set()
    for module in loading.modules:
        if module.tree.unread is None:
            return None
        names.update(module.tree.unread)
    return None if loading.missed else frozenset(names)


def read_source(path: Path) -> SourceFile:
    """Read one file, without its imports.

    Raises:
        InvalidScenario: The file cannot be read.
    """
    text = read_file(path)
    if isinstance(text, str):
        return SourceFile(str(path), text, path)
    fault = syntax.unreadable_file(Span(SourceFile(str(path), "", path), 0, 0), str(path), text.reason)
    raise InvalidScenario([fault])


def _load(loading: _Loading, file: SourceFile, path: Path, library: str | None) -> Module:
    """Parse a file and its imports, which are added first.

    The walk has its own stack, since chains of imports have no limit.
    """
    entry: Module | None = None
    stack: list[tuple[Module, Path, Iterator[ast.Statement]]] = []

    def enter(file: SourceFile, path: Path, library: str | None) -> Module:
        loading.seen.add(resolved(path))
        parse = loading.parsers.own if library is None else loading.parsers.library
        tree = parse(file, loading.bag)
        module = Module(tree.span.file, tree, library)  # an earlier file, if that has the same text
        stack.append((module, path, iter(module.tree.statements)))
        return module

    entry = enter(file, path, library)
    while stack:
        module, where, statements = stack[-1]
        statement = next(statements, None)
        if statement is None:
            loading.modules.append(module)
            stack.pop()
            continue
        found: tuple[SourceFile, Path, str | None] | None = None
        if loading.missed >= MAX_MISSES:
            pass
        elif isinstance(statement, ast.ImportModule):
            found = _find_module(loading, statement)
        elif isinstance(statement, ast.ImportUri):
            found = _find_file(loading, statement, where, module)
        if found is not None:
            enter(*found)
    return entry


def _find_module(loading: _Loading, statement: ast.ImportModule) -> tuple[SourceFile, Path, str] | None:
    """Find the file of a module, unless it is loaded or missing."""
    name = ".".join(statement.path)
    if name in loading.libraries:
        return None
    library = find_library(name, statement.span, loading.entry, loading.miss)
    if library is None:
        return None
    if name in STANDARD_MODULES:
        loading.uses |= STANDARD_MODULES[name][1]
    loading.libraries[name] = library
    path = library.path
    if resolved(path) in loading.seen:
        return None
    text = loading.read(path)
    if not isinstance(text, str):
        loading.miss(imports.missing_file(statement.span, name, f"{path}: {text.reason}"))
        return None
    return SourceFile(library.shown, text, path), path, name


def _find_file(
    loading: _Loading, statement: ast.ImportUri, where: Path, importer: Module
) -> tuple[SourceFile, Path, str | None] | None:
    """Find the file of a URI, relative to the importing file, unless it is loaded or missing."""
    if len(statement.uri) > MAX_PATH:
        reason = f"longer than {MAX_PATH} characters"
        loading.miss(imports.missing_file(statement.span, statement.uri, reason))
        return None
    path = path_of(statement.uri)
    if path is None:
        loading.miss(imports.unknown_scheme(statement.span, statement.uri.partition(":")[0]))
        return None
    full = loading.locate(path) if path.is_absolute() else where.parent / path
    if resolved(full) in loading.seen:
        return None
    text = loading.read(full)
    if not isinstance(text, str):
        loading.miss(imports.missing_file(statement.span, statement.uri, text.reason, not path.is_absolute()))
        return None
    is_shown = not importer.file.name.startswith("<")
    shown = str(Path(importer.file.name).parent / path) if is_shown else f"<{path}>"
    return SourceFile(shown, text, full), full, importer.library


def path_of(uri: str) -> Path | None:
    """Return the path of a `file:` URI or a plain path; None for other schemes."""
    try:
        parts = urlsplit(uri)
    except ValueError:  # an invalid host in brackets
        return None
    if len(parts.scheme) <= 1:  # none, or a drive
        return Path(unquote(uri))
    if parts.scheme != "file" or parts.netloc not in {"", "localhost"}:
        return None
    return Path(unquote(parts.path))
