"""Habits of other languages: their golden files, and repairs of their statements."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from seoro.lang import frontend
from seoro.lang.expression_habits import Habit
from seoro.lang.habits import foreign_format
from seoro.lang.line_habits import HABITS

GOLDENS = Path(__file__).parents[1] / "data" / "diagnostics"
SHOWN = "\n".join(path.read_text(encoding="utf-8") for path in GOLDENS.glob("*.err"))


def found(folder: Path, text: str) -> list[tuple[int, str]]:
    """Return lines and codes of the messages about a text."""
    path = folder / "test.osc"
    path.write_text(text, encoding="utf-8")
    checked = frontend.check(frontend.load(path))
    return [(each.primary.span.line, each.code) for each in checked.diagnostics]


@pytest.mark.parametrize("habit", HABITS, ids=lambda habit: habit.message)
def test_every_habit_is_quoted_in_a_golden_file(habit: Habit) -> None:
    pattern = r".*".join(re.escape(part) for part in re.split(r"\{\w+\}", habit.message))
    assert re.search(rf"E0138\]: {pattern}$", SHOWN, re.MULTILINE)


def test_a_repaired_statement_declares_its_names_and_its_block_is_checked(tmp_path: Path) -> None:
    text = "scenrio main:\n    n: int = 3\n    do serial:\n        wait n == 3\n        wait m == 3\n"
    assert found(tmp_path, text) == [(1, "E0138"), (5, "E0216")]


def test_names_that_a_broken_statement_may_declare_are_not_reported(tmp_path: Path) -> None:
    text = "struct a:\n    x: int = = 3\n    y: int = x + z\n"
    assert found(tmp_path, text) == [(2, "E0138"), (3, "E0216")]
    text = "struct a\nenum b [c, d]\nstruct e:\n    f: b = c\n    g: h\n"
    assert [line for line, _ in found(tmp_path, text)] == [2, 5]


def test_a_broken_constraint_declares_nothing(tmp_path: Path) -> None:
    assert found(tmp_path, "struct a:\n    keep(x x)\n    y: int = x\n") == [(2, "E0120"), (3, "E0216")]


def test_unknown_units_are_reported_despite_syntax_errors(tmp_path: Path) -> None:
    text = "import osc.types\nstruct a:\n    keep(1 1)\n    y: length = 3foo\n"
    assert found(tmp_path, text) == [(3, "E0120"), (4, "E0213")]


def test_names_after_a_broken_import_are_not_reported(tmp_path: Path) -> None:
    assert found(tmp_path, "import osc.\nstruct a:\n    b: nothing\n    c: int = 3x\n") == [(1, "E0120")]


@pytest.mark.parametrize(
    "text",
    ["", "# a: b\nscenario main\n", "scenario: main\n    do serial:\n", "struct a\n"],
)
def test_texts_like_scenarios_are_not_taken_for_another_format(text: str) -> None:
    assert foreign_format(text) == ""
