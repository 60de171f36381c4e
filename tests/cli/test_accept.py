"""`seoro accept`."""

import io
import json
import sys
from pathlib import Path

import pytest

from seoro.cli.main import main

SCENARIO = """import osc.types
import osc.helpers

scenario main:
    n: int
    keep(n in [1..3])
    do serial:
        wait elapsed(2s)
        log("done")
"""


@pytest.fixture
def traced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Path:
    """A folder with a scenario and its trace, as the working directory."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test.osc").write_text(SCENARIO)
    arguments = ["exec", "test.osc", "--clock", "virtual", "--seed", "1", "--set", "n=2", "--trace", "trace.jsonl"]
    assert main(arguments) == 0
    capsys.readouterr()
    return tmp_path


def edit(folder: Path, kind: str, **fields: object) -> None:
    """Change the first record of a kind."""
    records = [json.loads(line) for line in (folder / "trace.jsonl").read_text().splitlines()]
    next(record for record in records if record["kind"] == kind).update(fields)
    (folder / "trace.jsonl").write_text("".join(json.dumps(record) + "\n" for record in records))


def test_a_trace_that_is_accepted(traced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accept", "trace.jsonl", "test.osc"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith("accepted: ")


def test_a_trace_that_is_not(traced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(traced, "behavior.end", t=1.0)
    assert main(["accept", "trace.jsonl", "test.osc"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "error[E0530]: it ends at 1 s, but its event has not occurred then (wait, 7.6.2.5.3)" in err
    assert "8 |         wait elapsed(2s)" in err
    assert "(behavior.end at 1.0 s)" in err
    assert err.splitlines()[-1].startswith("not accepted: ")


def test_the_result_as_json(traced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(traced, "behavior.end", t=1.0)
    assert main(["accept", "--json", "trace.jsonl", "test.osc"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["accepted"]
    assert {violation["rule"] for violation in found["violations"]} == {"wait", "serial"}
    [wait] = [violation for violation in found["violations"] if violation["rule"] == "wait"]
    assert wait["section"] == "7.6.2.5.3"
    assert wait["source"] == "test.osc:8:9"
    assert len(wait["records"]) == 2
    assert found["not_checked"] == []


def test_unchecked_parts_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "test.osc").write_text(
        "scenario inner:\n    n: int\n    keep(default n == 3)\n\nscenario main:\n    do inner(n: 5)\n"
    )
    trace, scenario = str(tmp_path / "trace.jsonl"), str(tmp_path / "test.osc")
    assert main(["exec", scenario, "--scenario", "main", "--clock", "virtual", "--trace", trace]) == 0
    capsys.readouterr()
    assert main(["accept", trace, scenario]) == 0
    out = capsys.readouterr().out
    assert "test.osc:3:5: it is not decided whether this default is overridden (constraint, 7.6.2.3)" in out
    assert out.splitlines()[-1].endswith("apart from the parts not checked")


def test_a_trace_from_stdin(traced: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (traced / "trace.jsonl").read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text)))
    assert main(["accept", "-", "test.osc"]) == 0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "invalid trace trace.jsonl: file is empty"),
        ("hello\n", "invalid trace trace.jsonl: line 1: invalid JSON"),
        ("[1]\n", "not a JSON object"),
    ],
)
def test_other_files_are_rejected(
    traced: Path, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    (traced / "trace.jsonl").write_text(text)
    assert main(["accept", "trace.jsonl", "test.osc"]) == 2
    assert message in capsys.readouterr().err


def test_files_that_do_not_exist(traced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accept", "none.jsonl", "test.osc"]) == 2
    assert "cannot read the trace none.jsonl" in capsys.readouterr().err
    assert main(["accept", "trace.jsonl", "none.osc"]) == 2


def test_a_scenario_that_the_file_does_not_have(traced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(traced, "run.start", scenario="other")
    assert main(["accept", "trace.jsonl", "test.osc"]) == 2
    assert "other" in capsys.readouterr().err


def test_hostile_values_in_the_start_of_a_run(traced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(traced, "run.start", overrides=[1, 2])
    assert main(["accept", "trace.jsonl", "test.osc"]) == 2
    assert "overrides" in capsys.readouterr().err
