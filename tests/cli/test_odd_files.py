"""Pipes, devices and links instead of files: each command rejects them at once."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.security.keys.errors import InvalidKeys
from seoro.security.signing.audit_log import _lines

SCENARIO = "scenario main:\n    do emit end\n"


@pytest.fixture
def pipe(tmp_path: Path) -> str:
    path = tmp_path / "pipe.osc"
    os.mkfifo(path)
    return str(path)


@pytest.mark.parametrize(
    "command",
    [
        ["check"],
        ["fmt"],
        ["exec", "-n"],
        ["campaign", "run", "--list"],
        ["trace"],
    ],
)
def test_a_pipe_is_not_waited_for(pipe: str, capsys: pytest.CaptureFixture[str], command: list[str]) -> None:
    assert main([*command, pipe]) in (1, 2)
    err = capsys.readouterr().err
    assert "it is a pipe; expected a regular file" in err
    assert "internal error" not in err


def test_a_pipe_is_rejected_as_audit_log(pipe: str) -> None:
    with pytest.raises(InvalidKeys, match="it is a pipe; expected"):
        list(_lines(Path(pipe)))


@pytest.mark.parametrize("option", ["--lab", "--params", "--from-snapshot"])
def test_a_pipe_is_not_waited_for_by_options(
    tmp_path: Path, pipe: str, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    (tmp_path / "main.osc").write_text(SCENARIO)
    assert main(["exec", str(tmp_path / "main.osc"), option, pipe]) == 2
    assert "it is a pipe; expected a regular file" in capsys.readouterr().err


def test_a_pipe_is_not_imported(tmp_path: Path, pipe: str, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "main.osc").write_text(f'import "{Path(pipe).name}"\n{SCENARIO}')
    assert main(["check", str(tmp_path / "main.osc")]) == 2
    assert "it is a pipe" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command", [["check"], ["fmt"], ["exec", "-n"], ["campaign", "run", "--list"], ["trace"], ["accept"]]
)
def test_a_cyclic_link_is_not_an_internal_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    (tmp_path / "main.osc").write_text(SCENARIO)
    loop = tmp_path / "loop.osc"
    loop.symlink_to(loop)
    files = [str(loop), str(tmp_path / "main.osc")] if command == ["accept"] else [str(loop)]
    assert main([*command, *files]) in (1, 2)
    err = capsys.readouterr().err
    assert "Too many levels of symbolic links" in err
    assert "internal error" not in err


def test_an_integer_without_end_in_a_lab_file_is_shown_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "main.osc").write_text(SCENARIO)
    (tmp_path / "lab.yaml").write_text("bridges:\n  floor: " + "9" * 5000 + "\n")
    assert main(["exec", str(tmp_path / "main.osc"), "--lab", str(tmp_path / "lab.yaml")]) == 2
    assert "lab.yaml:2: invalid YAML: integer with 5000 characters" in capsys.readouterr().err


def start(**more: object) -> dict[str, object]:
    return {
        "seq": 0,
        "t": 0.0,
        "kind": "run.start",
        "scenario": "main",
        "file": "main.osc",
        "overrides": {},
        **more,
    }


def behavior(**more: object) -> dict[str, object]:
    about = {"id": 1, "parent": None, "type": "scenario", "name": "main", "path": "main"}
    return {"seq": 1, "t": 0.0, "kind": "behavior.start", "source": "main.osc:1:1", **about, **more}


@pytest.mark.parametrize(
    ("record", "message"),
    [
        (
            behavior(arguments=7),
            "line 2: not a record: `arguments` of `behavior.start` has the wrong type",
        ),
        (behavior(arguments="x"), "`arguments` of `behavior.start` has the wrong type"),
        (behavior(t=1e308), "line 2: time is not between 0 s and 1e+12 s"),
        (behavior(t=10**400), "line 2: time is not between"),
        (behavior(t=float("inf")), "line 2: time is not between"),
        (behavior(t=float("nan")), "line 2: time is not between"),
    ],
)
def test_a_record_that_cannot_be_is_shown_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], record: dict[str, object], message: str
) -> None:
    (tmp_path / "main.osc").write_text(SCENARIO)
    trace = tmp_path / "trace.jsonl"
    trace.write_text("".join(json.dumps(each) + "\n" for each in (start(), record)))
    assert main(["accept", str(trace), str(tmp_path / "main.osc")]) == 2
    assert message in capsys.readouterr().err
    for options in ([], ["--perfetto", str(tmp_path / "out.json")], ["--summary"]):
        assert main(["trace", str(trace), *options]) in (0, 2)
        assert "internal error" not in capsys.readouterr().err


@pytest.mark.parametrize("options", [[], ["--json"], ["--summary"]])
def test_a_lone_surrogate_is_not_an_internal_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str]
) -> None:
    trace = tmp_path / "trace.jsonl"
    log = {
        "seq": 1,
        "t": 0.0,
        "kind": "log",
        "message": "odd \ud800 text",
        "level": "info",
        "source": "main.osc:1:1",
    }
    trace.write_text("".join(json.dumps(each) + "\n" for each in (start(), log)))
    assert main(["trace", str(trace), *options]) in (0, 1, 2, 3)
    out, err = capsys.readouterr()
    assert "internal error" not in err
    out.encode()
    if options != ["--summary"]:
        assert "odd ? text" in out
