"""Contradictions that `seoro check` finds in what the entry scenario invokes."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.embed.contradictions import find_contradictions
from seoro.embed.scenarios import check_file

OTHER = """\
import osc.helpers
struct place:
    x: int
scenario other:
    x: int
    y: int = 4
    at: place
    keep(x < 3)
    keep(at.x > 0)
    keep(default y < 6)
    do log(x)
scenario middle:
    n: int
    m: int = n + 1
    do other(x: m)
action act:
    k: int
    keep(k > 0)
scenario main:
    a: int = 5
    b: int with:
        keep(it in [1..9])
    var c: int = 7
    p: place
    do serial:
"""


def lines(folder: Path, members: str) -> list[int]:
    """The lines, counted from the first member on, of the invocations that are reported."""
    file = folder / "test.osc"
    file.write_text(OTHER + "".join(f"        {line}\n" for line in members.splitlines()), encoding="utf-8")
    scenario = check_file(file, import_python=False)
    assert not scenario.checked.errors, scenario.checked.errors
    found = list(find_contradictions(scenario))
    assert all(each.code == "E0442" for each in found)
    places = [label.span for each in found for label in each.secondary if label.text == "invoked here"]
    assert len(places) == len(found)
    return [span.file.text.count("\n", 0, span.start) - OTHER.count("\n") for span in places]


@pytest.mark.parametrize(
    "member",
    [
        "other(x: 4)",
        "other(x: a)",
        "other(x: 2) with:\n    keep(it.x == 1)",
        "other() with:\n    keep(it.x == 7)",
        "other(y: a) with:\n    keep(it.y > a)",
        "other(x: 1, at: place(x: 0))",
        "other(x: 1) with:\n    keep(it.at.x < 0)",
        "act(k: 0)",
        "act(k: c) with:\n    keep(it.k < 0)",
        "other(x: 1, duration: 3s) with:\n    keep(it.duration.upper() < 2s)",
    ],
)
def test_arguments_that_contradict_constraints_are_found(member: str, tmp_path: Path) -> None:
    assert lines(tmp_path, f"{member}\nother(x: 1)") == [0]


def test_arguments_are_followed_through_invocations(tmp_path: Path) -> None:
    middle = OTHER[: OTHER.index("do other(x: m)")].count("\n") - OTHER.count("\n")
    assert lines(tmp_path, "middle(n: a)") == [middle]
    assert lines(tmp_path, "middle(n: 1)") == []


@pytest.mark.parametrize(
    "member",
    [
        "other(x: b)",  # drawn: some values fit
        "other(x: c)",  # a variable
        "other(y: c) with:\n    keep(it.y > 5)",
        "other(x: 1, at: p)",
        "other() with:\n    keep(it.x < b)",
        "other(x: 1) with:\n    keep(it.y == 9)",  # overrides the defaults
        "other(x: 1) with:\n    keep(it.y == c)\n    keep(it.y > 6)",
        "middle(n: b)",
        "act()",
    ],
)
def test_satisfiable_constraints_are_not_reported(member: str, tmp_path: Path) -> None:
    assert lines(tmp_path, member) == []


def test_endless_recursion_ends(tmp_path: Path) -> None:
    file = tmp_path / "test.osc"
    file.write_text("scenario main:\n    n: int = 1\n    keep(n > 0)\n    do main(n: n + 1)\n", encoding="utf-8")
    assert list(find_contradictions(check_file(file))) == []
