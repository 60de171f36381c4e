"""Trees of libraries in memory."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.lang import frontend, library_trees
from seoro.lang.diagnostic import Bag
from seoro.lang.library_trees import MAX_TREES, library_tree
from seoro.lang.source import SourceFile

TEXT = "struct s:\n    a: float = 1.0\n"


@pytest.fixture(autouse=True)
def _no_trees(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library_trees, "_trees", {})


def library(text: str = TEXT, name: str = "mine", shown: str = "<osc.mine>") -> SourceFile:
    return SourceFile(shown, text, Path(f"/libraries/{name}.osc"))


def test_an_unchanged_library_is_parsed_once() -> None:
    assert library_tree(library(), Bag()) is library_tree(library(), Bag())


@pytest.mark.parametrize(
    "other", [library(TEXT.replace("1.0", "2.0")), library(name="other"), library(shown="lib/mine.osc")]
)
def test_a_library_with_another_text_path_or_name_is_parsed(other: SourceFile) -> None:
    library_tree(library(), Bag())
    assert library_tree(other, Bag()).span.file is other


def test_errors_of_a_library_are_reported_at_each_load() -> None:
    for _ in range(2):
        bag = Bag()
        library_tree(library("struct s\n  oops\n"), bag)
        assert len(bag) > 0


def test_the_number_of_trees_is_limited() -> None:
    for number in range(MAX_TREES + 3):
        library_tree(library(name=str(number)), Bag())
    assert len(library_trees._trees) == MAX_TREES
    assert Path(f"/libraries/{MAX_TREES + 2}.osc") in library_trees._trees


def test_scenarios_share_the_trees_of_their_libraries(tmp_path: Path) -> None:
    path = tmp_path / "test.osc"
    path.write_text("import osc.types\nscenario main:\n    do serial:\n        wait elapsed(1s)\n")
    first, second = frontend.load(path), frontend.load(path)
    assert first.modules[0].tree is second.modules[0].tree
    assert first.entry.tree is not second.entry.tree
