"""Explanations of codes: the wrong example of each gives its message, the right one none.

`SEORO_UPDATE_GOLDENS=1 pytest tests/lang/test_explain.py` writes the messages into them.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Mapping
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.lang.explain import (
    EXAMPLE,
    FOLDER,
    PHASES,
    Example,
    Explanation,
    codes,
    explanation,
    explanations,
    near_codes,
    parse,
)
from seoro.lang.format.formatter import format_text
from seoro.lang.source import SourceFile

ROOT = Path(__file__).parents[2]
UPDATES = bool(os.environ.get("SEORO_UPDATE_GOLDENS"))
OWN = [path.stem for path in sorted(FOLDER.glob("E????.md"))]


def run(
    folder: Path, text: str, files: Mapping[str, str], command: str, capsys: pytest.CaptureFixture[str]
) -> tuple[int, str]:
    """Run a command on an example; return its exit status and its output on stderr."""
    for name, content in {EXAMPLE: text, **files}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content, encoding="utf-8")
    capsys.readouterr()
    name, *arguments = shlex.split(command)
    assert name == "seoro"
    status = main(arguments)
    return status, capsys.readouterr().err


def read(code: str) -> tuple[Explanation, Example]:
    found = explanation(code)
    assert found is not None
    return found, found.example


def codes_in_the_sources() -> set[str]:
    sources = (ROOT / "seoro").rglob("*.py")
    return {code for path in sources for code in re.findall(r'"(E\d{4})"', path.read_text(encoding="utf-8"))}


def test_every_code_has_an_explanation_and_every_explanation_a_code() -> None:
    assert set(codes()) == codes_in_the_sources()
    assert [item.code for item in explanations()] == list(codes())


@pytest.mark.parametrize("code", OWN)
def test_the_wrong_example_of_an_explanation_has_the_code(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    found, example = read(code)
    monkeypatch.syspath_prepend(tmp_path)  # for packages that an example installs
    _, message = run(tmp_path, example.wrong, example.files, example.command, capsys)
    message = message.partition("\n\n1 file checked")[0].rstrip() + "\n"
    if UPDATES:
        command = f"$ {example.command}\n"
        text = found.text.replace(f"{command}{example.message}```", f"{command}{message}```", 1)
        (FOLDER / f"{code}.md").write_text(text, encoding="utf-8")
        _, example = read(code)
    assert message == example.message
    found_codes = re.findall(r"^(\w+)\[(E\d{4})\]", message, re.MULTILINE)
    assert code in {found for _, found in found_codes}
    assert {found for severity, found in found_codes if severity == "error"} <= {code}


@pytest.mark.parametrize("code", OWN)
def test_the_right_example_of_an_explanation_has_no_errors(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    _, example = read(code)
    monkeypatch.syspath_prepend(tmp_path)
    files = {**example.files, **example.right_files}
    status, message = run(tmp_path, example.right, files, example.right_command, capsys)
    assert status == 0, message
    is_lint = code.startswith("E07")  # other examples show declarations without using them
    assert not [found for found in re.findall(r"\[(E\d{4})\]", message) if is_lint or not found.startswith("E07")]


@pytest.mark.parametrize("code", OWN)
def test_the_right_example_of_an_explanation_is_formatted(code: str) -> None:
    _, example = read(code)
    assert format_text(SourceFile(EXAMPLE, example.right)) == example.right


def test_titles_and_lines_of_explanations_are_short() -> None:
    for item in explanations():
        assert item.phase in PHASES.values()
        assert len(item.title) < 80 and not item.title.endswith("."), item.code
        assert max(map(len, item.meaning.splitlines())) <= 120, item.code


def test_codes_are_found_in_any_case_and_similar_ones_suggested() -> None:
    assert explanation("e0312") is not None
    assert explanation("E9999") is None
    assert explanation("../../../setup") is None
    assert "`E0312`" in near_codes("E0311")


def test_an_invalid_explanation_is_refused() -> None:
    with pytest.raises(ValueError, match="invalid explanation"):
        parse("# E0312: a title\n\nNo examples.\n")
