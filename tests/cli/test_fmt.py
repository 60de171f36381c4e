"""`seoro fmt`: files, output and exit status."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from seoro.cli.main import main

UNTIDY = "struct a:\n  x:int=3 # why\n"
TIDY = "struct a:\n    x: int = 3  # why\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_file_is_laid_out_in_place(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = folder / "a.osc"
    file.write_bytes(UNTIDY.replace("\n", "\r\n").encode("utf-8-sig"))
    file.chmod(0o640)
    assert main(["fmt", "a.osc"]) == 0
    assert file.read_bytes() == TIDY.encode()
    assert file.stat().st_mode & 0o7777 == 0o640
    out, err = capsys.readouterr()
    assert (out, err) == ("changed a.osc\n", "1 file changed\n")
    assert [path.name for path in folder.iterdir()] == ["a.osc"]
    assert main(["fmt", "a.osc"]) == 0
    assert capsys.readouterr() == ("", "1 file unchanged\n")


def test_a_link_stays_a_link(folder: Path) -> None:
    (folder / "a.osc").write_text(UNTIDY)
    (folder / "b.osc").symlink_to("a.osc")
    assert main(["fmt", "b.osc", "a.osc"]) == 0
    assert (folder / "b.osc").is_symlink()
    assert (folder / "a.osc").read_text() == TIDY


def test_hidden_folders_are_skipped(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("x/a.osc", "x/y/b.osc", "x/.hidden/c.osc", "x/d.txt"):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(UNTIDY)
    assert main(["fmt", "x", "x/a.osc"]) == 0
    assert capsys.readouterr() == ("changed x/a.osc\nchanged x/y/b.osc\n", "2 files changed\n")
    assert (folder / "x/.hidden/c.osc").read_text() == UNTIDY
    assert (folder / "x/d.txt").read_text() == UNTIDY


def test_check_writes_nothing_and_fails(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.osc").write_text(UNTIDY)
    (folder / "b.osc").write_text(TIDY)
    assert main(["fmt", "--check", "."]) == 1
    assert capsys.readouterr() == ("", "would change a.osc\n1 file would change, 1 file unchanged\n")
    assert (folder / "a.osc").read_text() == UNTIDY
    assert main(["fmt", "--check", "b.osc"]) == 0


def test_a_diff_is_shown(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.osc").write_text(UNTIDY)
    assert main(["fmt", "--diff", "a.osc"]) == 0
    out, _ = capsys.readouterr()
    assert out == (
        "--- a.osc\n+++ a.osc\n@@ -1,3 +1,3 @@\n struct a:\n-  x:int=3 # why\n+    x: int = 3  # why\n \n"
    )
    assert (folder / "a.osc").read_text() == UNTIDY


def test_a_file_with_errors_is_left_as_it_is(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "a.osc").write_text("struct a:\n  x:int=\n")
    (folder / "b.osc").write_text(UNTIDY)
    (folder / "c.osc").write_bytes(b"\xff")
    assert main(["fmt", "a.osc", "b.osc", "c.osc", "nope.osc"]) == 2
    out, err = capsys.readouterr()
    assert out == "changed b.osc\n"
    assert " --> a.osc:2:" in err
    assert "cannot read `c.osc`: not UTF-8" in err
    assert "cannot read `nope.osc`: No such file or directory" in err
    assert err.endswith("1 file changed, 3 files could not be formatted\n")
    assert (folder / "a.osc").read_text() == "struct a:\n  x:int=\n"


@pytest.mark.parametrize(
    ("options", "data", "status", "out"),
    [
        ([], UNTIDY.encode(), 0, TIDY),
        ([], b"struct a:\n", 2, ""),
        (["--check"], UNTIDY.encode(), 1, ""),
        (["--check"], TIDY.encode(), 0, ""),
        ([], b"\xff", 2, ""),
    ],
)
def test_stdin_goes_to_stdout(
    options: list[str],
    data: bytes,
    status: int,
    out: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    assert main(["fmt", *options, "-"]) == status
    assert capsys.readouterr().out == out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [(["-", "a.osc"], "`-` cannot be combined"), (["empty"], "no .osc files in the folder `empty`")],
)
def test_invalid_arguments_are_rejected(
    folder: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "empty").mkdir()
    assert main(["fmt", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_leaves_the_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "a.osc").write_text(UNTIDY)

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", fail)
    assert main(["fmt", "a.osc"]) == 3
    assert [(path.name, path.read_text()) for path in folder.iterdir()] == [("a.osc", UNTIDY)]
