"""The check of prose: texts that it finds, and rules that it applies."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.tools.prose.__main__ import main
from tests.tools.prose.rules import check
from tests.tools.prose.texts import Kind, Text, texts_in

MODULE = '''"""Module of a test."""

LIMIT = 3  # of what may be sent
"""Number of messages."""


def is_open(door: str) -> bool:
    """Whether a door is open.

    Args:
        door: Name of the door,
            on two lines.
    """
    raise ValueError(f"unknown door {door!r} of this house")
'''


def texts_of(tmp_path: Path, name: str, content: str) -> list[tuple[Kind, str]]:
    file = tmp_path / name
    file.write_text(content)
    return [(each.kind, each.text) for each in texts_in(file)]


def test_texts_of_a_module_have_their_kinds(tmp_path: Path) -> None:
    assert texts_of(tmp_path, "module.py", MODULE) == [
        (Kind.DOCSTRING, "Module of a test."),
        (Kind.DOCSTRING, "Number of messages."),
        (Kind.PREDICATE, "Whether a door is open."),
        (Kind.ENTRY, "Name of the door, on two lines."),
        (Kind.STRING, "unknown door `x` of this house"),
        (Kind.COMMENT, "of what may be sent"),
    ]


def test_a_page_has_paragraphs_and_cells_but_no_code(tmp_path: Path) -> None:
    page = "# A page\n\nFirst line\nand second.\n\n```\nwhat is code\n```\n\n| a | two words here |\n|---|---|\n"
    assert texts_of(tmp_path, "page.md", page) == [
        (Kind.PAGE, "A page"),
        (Kind.PAGE, "First line and second."),
        (Kind.PAGE, "two words here"),
    ]


def test_comments_behind_code_stand_alone(tmp_path: Path) -> None:
    module = "LEFT = 1  # of the left wheel\nRIGHT = 2  # of the right wheel\n# Both are\n# in meters.\n"
    assert texts_of(tmp_path, "module.py", module) == [
        (Kind.COMMENT, "of the left wheel"),
        (Kind.COMMENT, "of the right wheel"),
        (Kind.COMMENT, "Both are in meters."),
    ]


def test_comments_of_scenarios_are_texts(tmp_path: Path) -> None:
    assert texts_of(tmp_path, "main.osc", "# Drive to\n# the goal.\nscenario main:\n    pass\n") == [
        (Kind.COMMENT, "Drive to the goal.")
    ]


@pytest.mark.parametrize(
    ("kind", "text", "rules"),
    [
        (Kind.DOCSTRING, "What a node sends.", ["question"]),
        (Kind.DOCSTRING, "Whether it is open.", ["question"]),
        (Kind.PREDICATE, "Whether it is open.", []),
        (Kind.ENTRY, "Who sends.", ["question"]),
        (Kind.PAGE, "When the router restarts, runs continue.", []),
        (Kind.PAGE, "What runs where?", []),
        (Kind.STRING, "there is no file `x`", ["negation"]),
        (Kind.STRING, "the node is no longer reached", []),
        (Kind.STRING, "the trace does not tell the value", ["saying"]),
        (Kind.COMMENT, "as the caller is told", ["saying"]),
        (Kind.PAGE, "Use `tell` here.", []),
        (Kind.DOCSTRING, "Robots of whoever has left.", ["vague"]),
        (Kind.COMMENT, "as somebody sent it", ["vague"]),
        (Kind.PAGE, "The page shows what is kept.", []),
        (Kind.PAGE, "Somebody keeps it.", ["vague"]),
        (Kind.DOCSTRING, "Send " + "a word " * 15 + ".", ["long"]),
        (Kind.DOCSTRING, "Send a message. Return its number.", []),
    ],
)
def test_rules_find_forbidden_sentences(kind: Kind, text: str, rules: list[str]) -> None:
    assert [each.rule for each in check(Text(Path("a.py"), 1, kind, text))] == rules


def test_the_command_prints_findings_and_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "page.md"
    file.write_text("Good words.\n\nThere is no file.\n")
    assert main([str(file)]) == 1
    assert capsys.readouterr().out == f"{file}:3: negation: There is no file.\n"


def test_the_command_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "page.md").write_text("There is no file.\n")
    assert main(["--count", str(tmp_path)]) == 0
    assert "negation      1  1 in a page" in capsys.readouterr().out
