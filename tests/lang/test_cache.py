"""Trees of libraries on disk."""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import pytest

from seoro.files.cache import MAX_SIZE
from seoro.lang import ast, cache, frontend, library_trees
from seoro.lang.builtin_libraries import builtin_libraries
from seoro.lang.cache import parse_library
from seoro.lang.diagnostic import Bag
from seoro.lang.parser import parse_file
from seoro.lang.source import SourceFile, Span

TEXT = (
    'struct s:\n    a: float = 1.0 + -2 * (3.0)\n    b: list of string = [\'x\', """é\ny"""]\n    c: float = inf\n'
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "seoro" / "trees"


def library(text: str = TEXT, name: str = "mine") -> SourceFile:
    return SourceFile(f"<osc.{name}>", text, Path(f"/libraries/{name}.osc"))


def dump(value: object) -> object:
    """Return a tree as data, with positions and types."""
    if isinstance(value, ast.Node):
        return type(value).__name__, [dump(getattr(value, field.name)) for field in fields(value)]
    if isinstance(value, Span):
        return value.start, value.end
    return [dump(item) for item in value] if isinstance(value, tuple) else (type(value).__name__, value)


def kept(folder: Path) -> Path:
    """Return the file of the only tree in the cache."""
    (found,) = folder.iterdir()
    return found


def write(path: Path, content: bytes) -> None:
    """Replace a cached tree by data with their checksum."""
    path.write_bytes(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)


@pytest.mark.parametrize("path", sorted(set(builtin_libraries().values())), ids=lambda path: path.stem)
def test_the_cached_tree_equals_the_parsed_one(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = SourceFile(path.name, path.read_text(encoding="utf-8"), path)
    parsed = parse_library(file, Bag())
    monkeypatch.setattr(cache, "parse_file", None)
    again = parse_library(file, Bag())
    assert again is not parsed
    assert dump(again) == dump(parsed)
    assert again.span.file is file


def test_a_cached_tree_is_readable_by_its_user_only(folder: Path) -> None:
    parse_library(library(), Bag())
    assert kept(folder).stat().st_mode & 0o777 == 0o600
    assert folder.stat().st_mode & 0o077 == 0


def test_a_changed_text_is_parsed_and_replaces_the_cached_tree(folder: Path) -> None:
    parse_library(library(), Bag())
    parse_library(library(name="other"), Bag())
    changed = TEXT.replace("1.0", "4.0")
    assert dump(parse_library(library(changed), Bag())) == dump(parse_file(library(changed), Bag()))
    assert sorted(path.name.partition("-")[0] for path in folder.iterdir()) == ["mine", "other"]


def test_texts_with_errors_are_not_cached(folder: Path) -> None:
    for _ in range(2):
        bag = Bag()
        parse_library(library("struct s\n  oops\n"), bag)
        assert len(bag) > 0
    assert not folder.exists()


@pytest.fixture
def large_limit() -> Iterator[None]:
    """Set a recursion limit as after an earlier parse."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(50_000)
    yield
    sys.setrecursionlimit(before)


@pytest.mark.usefixtures("large_limit")
def test_a_deep_tree_is_not_cached(folder: Path) -> None:
    text = f"struct s:\n    a: int = {' + '.join(['1'] * 5000)}\n"
    assert parse_library(library(text), Bag()).statements
    assert not folder.exists()


CONTENT = json.dumps([0, 0, 1, "a", None])
FOREIGN = {
    "empty": b"",
    "text": b"no tree",
    "null": b"null",
    "number": b"7",
    "mapping": b'{"a": 1}',
    "no class": b"[]",
    "unknown class": b"[4711, 0, 1, [-1], [-1]]",
    "negative class": b"[-2, 0, 1, [-1], [-1]]",
    "class by name": b'["OscFile", 0, 1, [-1], [-1]]',
    "too few fields": b"[0, 0, 1]",
    "another node": CONTENT.encode(),
    "end before start": b"[%d, 5, 1, [-1], [-1]]",
    "beyond the text": b"[%d, 0, 100000, [-1]]",
    "negative start": b"[%d, -1, 1, [-1], [-1]]",
    "no number for a place": b'[%d, "a", 1, [-1], [-1]]',
    "no whole number for a place": b"[%d, 0.5, 1, [-1], [-1]]",
    "too many fields": b"[%d, 0, 1, [-1], [-1], 3]",
    "nested without end": b"[" * 100_000,
    "nested without end and closed": b"[-1," * 5000 + b"0" + b"]" * 5000,
}


@pytest.mark.parametrize("kind", FOREIGN)
def test_an_invalid_cache_file_is_parsed_again_and_replaced(kind: str, folder: Path) -> None:
    expected = dump(parse_library(library(), Bag()))
    path = kept(folder)
    good = path.read_bytes()
    number = json.loads(good.partition(b"\n")[2])[0]
    content = FOREIGN[kind]
    write(path, content % number if b"%d" in content else content)
    assert dump(parse_library(library(), Bag())) == expected
    assert path.read_bytes() == good


@pytest.mark.parametrize("cut", [0, 1, 64, 65, 70, -1])
def test_a_truncated_cached_tree_is_parsed_again(cut: int, folder: Path) -> None:
    expected = dump(parse_library(library(), Bag()))
    path = kept(folder)
    path.write_bytes(path.read_bytes()[:cut])
    assert dump(parse_library(library(), Bag())) == expected


def test_a_corrupt_cached_tree_is_parsed_again(folder: Path) -> None:
    expected = dump(parse_library(library(), Bag()))
    path = kept(folder)
    path.write_bytes(path.read_bytes().replace(b'"x"', b'"z"'))
    assert dump(parse_library(library(), Bag())) == expected


def test_a_cached_tree_beyond_the_size_limit_is_not_read(folder: Path) -> None:
    expected = dump(parse_library(library(), Bag()))
    path = kept(folder)
    with path.open("ab") as stream:
        stream.truncate(MAX_SIZE + 1)
    assert dump(parse_library(library(), Bag())) == expected


def test_an_unwritable_cache_folder_is_ignored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert parse_library(library(), Bag()).statements


def test_parsing_works_without_a_home_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    assert parse_library(library(), Bag()).statements


def test_a_failed_write_leaves_no_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "fdopen", full)
    assert parse_library(library(), Bag()).statements
    assert list(folder.iterdir()) == []


def test_libraries_are_cached_but_not_scenarios(
    tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(library_trees, "_trees", {})
    path = tmp_path / "test.osc"
    path.write_text("import osc.types\nscenario main:\n    do serial:\n        wait elapsed(1s)\n")
    first, second = frontend.load(path), frontend.load(path)
    assert [dump(module.tree) for module in first.modules] == [dump(module.tree) for module in second.modules]
    assert kept(folder).name.startswith("types-")
    assert frontend.lower(frontend.check(second)).entry == "main"
