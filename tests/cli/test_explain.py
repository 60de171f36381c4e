"""`seoro explain`: output, and unknown codes."""

import json

import pytest

from seoro.cli import explain_command
from seoro.cli.main import main
from seoro.lang.explain import codes


def test_an_explanation_is_plain_where_no_terminal_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "e0312"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("# E0312: ")
    assert "error[E0312]: `length` and `speed` cannot be added\n --> example.osc:4:21\n" in out
    assert "\x1b" not in out


def test_a_terminal_gets_it_rendered(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(explain_command, "use_colour", lambda file: True)
    assert main(["explain", "E0312"]) == 0
    out = capsys.readouterr().out
    assert "# E0312" not in out
    assert "```" not in out
    assert "cannot be added" in out


def test_without_a_code_all_are_listed_by_phase(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("Reading and parsing\n  E0101  Unreadable file\n")
    assert "\n\nTypes and expressions\n  E0301  " in out
    assert [line.split()[0] for line in out.splitlines() if line.startswith("  ")] == list(codes())


def test_json_has_the_examples(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "--json", "E0312", "E0301"]) == 0
    first, second = json.loads(capsys.readouterr().out)
    assert (first["code"], second["code"]) == ("E0312", "E0301")
    assert set(first) == {"code", "phase", "title", "meaning", "wrong", "message", "right"}
    assert first["wrong"].startswith("import osc.types\n")


@pytest.mark.parametrize(
    ("code", "hint"), [("E0311", "`E0312`"), ("312", "`E0312`"), ("nonsense", "lists all codes")]
)
def test_an_unknown_code_names_near_ones(code: str, hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", code]) == 2
    err = capsys.readouterr().err
    assert f"unknown code `{code}`" in err
    assert hint in err
