"""`seoro check`."""

import json
from pathlib import Path

import pytest

from seoro.cli.main import main


def test_good_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.osc").write_text("scenario main:\n    do serial:\n        emit end\n")
    assert main(["check", str(tmp_path / "a.osc")]) == 0
    assert capsys.readouterr().out == "1 file checked: no errors\n"


def test_errors_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text("import osc.types\nscenario main:\n    do wait elapsed(3m)\n")
    assert main(["check", "--format", "json", str(file)]) == 2
    [found] = json.loads(capsys.readouterr().out)
    assert set(found) == {
        "file", "line", "column", "end_line", "end_column", "severity", "code", "message", "help"
    }  # fmt: skip
    assert (found["file"], found["line"], found["severity"]) == (str(file), 3, "error")


def test_extensions_are_reported_when_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text("import osc.types\nscenario main:\n    pause: time = 3\n    do wait elapsed(pause)\n")
    assert main(["check", str(file)]) == 0
    assert capsys.readouterr().err == ""
    main(["check", "--strict", str(file)])
    assert "a.osc:3:" in capsys.readouterr().err


def test_the_published_scenarios_are_valid() -> None:
    scenarios = Path(__file__).parents[2] / "scenarios"
    files = [str(path) for path in scenarios.rglob("*.osc")]
    assert files
    assert main(["check", *files]) == 0
