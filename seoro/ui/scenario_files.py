"""Scenario files below the folders of a site."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any, Final

from seoro.embed.directives import directive_comments
from seoro.errors import InvalidScenario
from seoro.lang import ast
from seoro.lang.comments import comment_above
from seoro.lang.diagnostic import Bag, Severity
from seoro.lang.loader import read_source
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile
from seoro.ui.answers import RequestError
from seoro.ui.walking import walk

MOST_FILES: Final = 2000
_SUFFIX: Final = ".osc"
_LONGEST_DOC: Final = 500  # [characters]


@dataclass(frozen=True)
class Listed:
    """A scenario file in the list.

    Args:
        stamp: Size and time of its last change.
        scenarios: JSON data of its scenarios; one with `problem` if it cannot be read.
    """

    stamp: tuple[int, int]
    scenarios: tuple[dict[str, Any], ...]


class ScenarioFiles:
    """Finds the scenario files below folders. Threads may share it.

    Args:
        roots: The folders, absolute.
    """

    def __init__(self, roots: Sequence[Path]) -> None:
        self._roots = roots
        self._lock = Lock()
        self._listed: dict[Path, Listed] = {}
        self._paths: dict[str, Path] = {}

    def list(self) -> list[dict[str, Any]]:
        """Return the JSON data of all scenarios."""
        with self._lock:
            before, self._listed, self._paths = self._listed, {}, {}
            for path in self._files():
                name = self._name(path)
                self._paths[name] = path
                try:
                    found = path.stat()
                except OSError:
                    continue  # deleted meanwhile
                stamp = (found.st_size, found.st_mtime_ns)
                known = before.get(path)
                if known is None or known.stamp != stamp:
                    known = Listed(stamp, tuple(_scenarios(path, name)))
                self._listed[path] = known
            return [each for found_file in self._listed.values() for each in found_file.scenarios]

    def path(self, name: str) -> Path:
        """Return the path of a listed file.

        Raises:
            RequestError: The file is not in the list.
        """
        if name not in self._paths:
            self.list()
        found = self._paths.get(name)
        if found is None:
            raise RequestError(404, "unknown scenario file", "choose a file below the folders of the site", "file")
        return found

    def _files(self) -> Iterator[Path]:
        count = 0
        for folder, _, files in walk(self._roots):
            for name in sorted(files):
                if name.endswith(_SUFFIX):
                    yield folder / name
                    count += 1
                    if count >= MOST_FILES:
                        return

    def _name(self, path: Path) -> str:
        """Return the name of a file: relative to the only folder of the site, or else absolute."""
        [root, *others] = self._roots
        return str(path.relative_to(root)) if not others else str(path)


def _scenarios(path: Path, name: str) -> Iterator[dict[str, Any]]:
    bag = Bag()
    try:
        file = read_source(path)
        tree = parse_file(file, bag)
    except InvalidScenario as error:
        yield _unreadable(name, error.diagnostics[0].message)
        return
    errors = [each for each in bag.diagnostics if each.severity is Severity.ERROR]
    found = [each for each in tree.statements if isinstance(each, ast.ScenarioDeclaration) and _is_entry(each)]
    if errors:
        line = errors[0].primary.span.line
        yield _unreadable(name, f"line {line}: {errors[0].message}", line)
    for each in found if not errors else ():
        line = each.name.span.line
        yield {"file": name, "name": each.name.name.text, "doc": _doc(file, line), "line": line}


def _is_entry(declaration: ast.ScenarioDeclaration) -> bool:
    return declaration.name.actor is None


def _unreadable(name: str, problem: str, line: int = 1) -> dict[str, Any]:
    return {"file": name, "name": "", "doc": "", "line": line, "problem": problem}


def _doc(file: SourceFile, line: int) -> str:
    """Return the comment above a scenario, or else the one at the top of its file, without directives."""
    directives = {number for number, *_ in directive_comments(file)}
    own = _plain(file, line, directives)
    if own:
        return own
    first = next((number for number in range(1, line) if not file.line(number).startswith("#")), line)
    return _plain(file, first, directives)


def _plain(file: SourceFile, line: int, directives: set[int]) -> str:
    found = comment_above(file, line).splitlines()
    numbers = range(line - len(found), line)
    lines = [text for number, text in zip(numbers, found, strict=True) if number not in directives]
    return " ".join(" ".join(lines).split())[:_LONGEST_DOC]
