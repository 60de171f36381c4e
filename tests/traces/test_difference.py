from __future__ import annotations

import json
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.traces.difference import first_difference
from tests.report.traces import records, write


def test_equal_runs_have_no_difference() -> None:
    second = records()
    for number, record in enumerate(second):
        record |= {"seq": number + 5, "wall": "later", "cause": 1}
    assert first_difference(records(), second) is None


def test_orders_within_an_instant_mean_nothing() -> None:
    second = records()
    second[2], second[3] = second[3], second[2]
    assert first_difference(records(), second) is None


def test_the_first_instant_with_other_records_is_found() -> None:
    second = [record for record in records() if record["kind"] != "variable"]
    found = first_difference(records(), second)
    assert found is not None
    assert (found.common, found.first.time, found.second.time) == (0.0, 2.0, 2.0)
    assert [record["kind"] for record in found.first.records] == ["variable"]
    assert found.second.records == ()


def test_a_run_that_ends_early_is_found() -> None:
    found = first_difference(records(), [record for record in records() if record["t"] < 3])
    assert found is not None
    assert (found.common, found.first.time, found.second.time) == (2.0, 5.0, None)


def test_seoro_compare_prints_settings_and_the_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    second = records()
    second[0] |= {"seed": 8, "parameters": {"robot": "tb5"}}
    next(record for record in second if record["kind"] == "variable")["value"] = 3
    write(Path("a"), records())
    write(Path("b"), second)
    assert main(["compare", "a", "a"]) == 0
    assert "equal: everything happened at the same times" in capsys.readouterr().out
    assert main(["compare", "a", "b"]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "a: main failed after 5.000 s: timeout: still running after 5 s",
        "b: main failed after 5.000 s: timeout: still running after 5 s",
        "  seed: 7 and 8",
        '  parameter robot: "tb4" and "tb5"',
        "equal until 0.000 s, then:",
        "  only in A, at 2.000 s:",
        "    = count 2",
        "  only in B, at 2.000 s:",
        "    = count 3",
    ]
    assert main(["compare", "a", "b", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["difference"]["common"] == 0.0
    Path("c.jsonl").write_text("".join(json.dumps(record) + "\n" for record in second[1:]))
    assert main(["compare", "a", "c.jsonl"]) == 2
    assert "the trace c.jsonl has no beginning" in capsys.readouterr().err
