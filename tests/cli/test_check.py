"""`seoro check`."""

import json
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest

from seoro.cli.main import main


def test_good_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.osc").write_text("scenario main:\n    do serial:\n        emit end\n")
    assert main(["check", str(tmp_path / "a.osc")]) == 0
    assert capsys.readouterr().out == "1 file checked: no errors\n"


def test_a_file_is_read_from_stdin(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.stdin", TextIOWrapper(BytesIO(b"scenario main:\n    do nothing_known()\n")))
    assert main(["check", "-"]) == 2
    assert " --> <stdin>:2:8\n" in capsys.readouterr().err


def test_errors_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text("import osc.types\nscenario main:\n    do wait elapsed(3m)\n")
    assert main(["check", "--format", "json", str(file)]) == 2
    [found] = json.loads(capsys.readouterr().out)
    assert set(found) == {
        "file", "line", "column", "end_line", "end_column", "severity", "code", "message", "help"
    }  # fmt: skip
    assert (found["file"], found["line"], found["severity"]) == (str(file), 3, "error")


def test_strict_option_reports_extensions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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


ERRONEOUS = "struct a:\n    x: int = 1.5\n    y: int = true\n"


def test_each_file_of_folders_is_checked_one_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("a.osc", "deep/er/b.osc", ".hidden/c.osc"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(ERRONEOUS)
    (tmp_path / "notes.txt").write_text("no scenario")
    assert main(["check", str(tmp_path / "a.osc"), str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("error[E0301]") == 4
    assert err.endswith("\n\n2 files checked: 4 errors\n`seoro explain E0301` explains the error\n")


def test_errors_of_an_imported_file_are_reported_one_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("parts.osc").write_text(ERRONEOUS)
    Path("a.osc").write_text('import "parts.osc"\n')
    Path("b.osc").write_text('import "parts.osc"\n')
    assert main(["check", "--format", "json", "."]) == 2
    found = json.loads(capsys.readouterr().out)
    assert [(item["file"], item["line"]) for item in found] == [("parts.osc", 2), ("parts.osc", 3)]


def test_each_missing_file_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = tmp_path / "a.osc"
    good.write_text("struct a\n")
    assert main(["check", "x.osc", str(good), "y.osc"]) == 2
    err = capsys.readouterr().err
    assert "cannot read `x.osc`: No such file or directory" in err
    assert "cannot read `y.osc`: No such file or directory" in err
    assert "3 files checked: 2 errors\n" in err


def test_a_folder_without_scenarios_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(tmp_path)]) == 2
    assert "no .osc files in the folder" in capsys.readouterr().err


def test_warnings_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text("import osc.helpers\n")
    assert main(["check", "--strict", str(file)]) == 0
    out, err = capsys.readouterr()
    assert err.startswith("warning[E0392]")
    assert out == "1 file checked: no errors, 1 warning\n`seoro explain E0392` explains the warning\n"


def test_json_of_files_without_errors_is_an_empty_list(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text("struct a\n")
    assert main(["check", "--format", "json", str(file)]) == 0
    assert json.loads(capsys.readouterr().out) == []


CONFLICT = """\
scenario main:
    a: int
    keep(a > 5)
    keep(a < 3)
    do emit end
"""


def test_constraints_of_the_entry_that_clash_are_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "clash.osc"
    file.write_text(CONFLICT)
    assert main(["check", str(file)]) == 2
    errors = capsys.readouterr().err
    assert "E0442" in errors and "keep(a > 5)" in errors and "keep(a < 3)" in errors


@pytest.mark.parametrize(
    "text",
    [
        "scenario main:\n    a: int\n    do emit end\n",
        "scenario main:\n    a: int\n    keep(a > 5)\n    do emit end\n",
        CONFLICT.replace("main", "one") + CONFLICT.replace("main", "other"),
        "scenario main:\n    a: int = 3\n    keep(a in [6..7])\n    do emit end\n",
    ],
    ids=["override", "bounds", "no entry", "overridden"],
)
def test_parameters_without_values_are_valid(text: str, tmp_path: Path) -> None:
    file = tmp_path / "fine.osc"
    file.write_text(text)
    assert main(["check", str(file)]) == 0
