"""`seoro trace`: output, and broken files."""

import io
import json
import subprocess
import sys
from pathlib import Path

import pytest

from seoro.cli.main import main

SCENARIO = """import osc.types
import osc.helpers

scenario main:
    do serial:
        log("one")
        wait elapsed(2s)
        log("two")
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str:
    monkeypatch.chdir(tmp_path)
    Path("test.osc").write_text(SCENARIO)
    assert main(["exec", "test.osc", "--clock", "virtual", "--seed", "1", "--trace", "trace.jsonl"]) == 0
    capsys.readouterr()
    return "trace.jsonl"


def test_a_trace_is_shown(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trace", file]) == 0
    out, err = capsys.readouterr()
    assert "2.000          " not in out
    assert '" two' in out
    assert out.splitlines()[-1].strip() == "2.000  | passed"
    assert err == ""


def test_records_are_chosen(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trace", file, "--kind", "log", "--from", "1s", "--json"]) == 0
    assert [json.loads(line)["message"] for line in capsys.readouterr().out.splitlines()] == ["two"]
    assert main(["trace", file, "--grep", "^on.$", "--kind", "log", "--json"]) == 0
    assert [json.loads(line)["message"] for line in capsys.readouterr().out.splitlines()] == ["one"]


def test_filters_without_matches_print_a_note(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trace", file, "--kind", "logs"]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert "matches; kinds: behavior.end, behavior.start, event, " in err


def test_a_summary_for_machines_is_one_object(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trace", file, "--summary", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "passed"


def test_a_trace_is_converted(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trace", file, "--perfetto", "out.json"]) == 0
    assert "ui.perfetto.dev" in capsys.readouterr().out
    assert json.loads(Path("out.json").read_text())["traceEvents"]


def test_stdin_is_read(file: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(Path(file).read_bytes())))
    assert main(["trace", "-", "--summary"]) == 0
    assert capsys.readouterr().out.startswith("passed  main in 2.000 s")


def test_the_trace_of_a_killed_run_is_printed_with_a_warning(
    file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path(file).write_bytes(Path(file).read_bytes()[:-200])
    assert main(["trace", file]) == 0
    out, err = capsys.readouterr()
    assert "scenario main" in out
    assert (
        err == "warning: the trace has no `run.end`, the last line is truncated: "
        "the run was killed, or is still active\n"
    )


def test_broken_lines_are_reported_and_valid_ones_printed(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    lines = Path(file).read_text().splitlines()
    lines[3] = "{"
    Path(file).write_text("\n".join(lines) + "\n")
    assert main(["trace", file]) == 0
    out, err = capsys.readouterr()
    assert '" two' in out
    assert err == "warning: trace.jsonl, line 4: invalid JSON\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "invalid trace other: file is empty"),
        ("scenario main:\n    do log()\n", "invalid trace other: line 1: invalid JSON"),
    ],
)
def test_other_files_are_rejected(file: str, capsys: pytest.CaptureFixture[str], text: str, message: str) -> None:
    Path("other").write_text(text)
    assert main(["trace", "other"]) == 2
    assert message in capsys.readouterr().err


def test_unreadable_and_unwritable_files_are_reported(file: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trace", "missing"]) == 2
    assert "cannot read the trace missing: No such file" in capsys.readouterr().err
    assert main(["trace", file, "--perfetto", "/proc/nowhere"]) == 2
    assert "cannot write /proc/nowhere" in capsys.readouterr().err
    assert main(["trace", file, "--perfetto", "x", "--json"]) == 2
    assert "leave out one of them" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments", [["--from", "soon"], ["--to", "inf"], ["--grep", "("], ["--summary", "--perfetto", "x"]]
)
def test_a_wrong_option_is_refused(file: str, arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["trace", file, *arguments])
    assert caught.value.code == 2


def test_a_closed_pipe_ends_the_output(file: str) -> None:
    command = [sys.executable, "-m", "seoro", "trace", file]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(timeout=20) == 0
