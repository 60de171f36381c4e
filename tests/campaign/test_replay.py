"""Runs of campaigns that are found and repeated."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from seoro.campaign.after.finding import find_failed, find_run
from seoro.campaign.after.traces import digest_of, first_difference
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.store.folder import ASKED, RUNS
from seoro.cli.main import main
from seoro.errors import UsageError
from tests.campaign.generated import generate
from tests.campaign.test_campaigns import table

TEXT = """import osc.types
import osc.helpers

scenario main:
    load: float with:
        keep(it in [0.2, 0.4, 0.6])
    name: string
    do serial:
        log(name)
        wait elapsed(2s)
        compare(load, "<", 0.5)
"""


@pytest.fixture
def campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Path:
    """Three runs on the virtual clock, the third of which failed."""
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    command = [
        "campaign",
        "run",
        "main.osc",
        "--set",
        'name="a b"',
        "--clock",
        "virtual",
        "--seed",
        "5",
        "-j",
        "1",
    ]
    assert main(command) == 1
    capsys.readouterr()
    return Path("campaign")


def change(file: Path, pattern: str, text: str) -> None:
    file.write_text(re.sub(pattern, text, file.read_text()))


def test_a_run_is_repeated_to_the_bit(
    campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["campaign", "replay", "campaign", "3"]) == 0
    assert "equal: the trace is that of run 3 to the bit" in capsys.readouterr().out
    assert Path("campaign/replayed/000003/trace.jsonl").is_file()
    Path("elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")
    by_id = table("../campaign/runs.csv")[0]["id"][:8]
    assert main(["campaign", "replay", "../campaign", by_id, "-o", "again"]) == 0
    assert "equal: the trace is that of run 1 to the bit" in capsys.readouterr().out
    assert (tmp_path / "elsewhere" / "again" / "trace.jsonl").is_file()


def test_the_first_record_that_differs_is_shown(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shard = next((campaign / RUNS).glob("*.jsonl"))
    change(shard, r'"trace_sha": "[0-9a-f]{64}"', f'"trace_sha": "{"0" * 64}"')
    change(campaign / "kept" / "000003" / "trace.jsonl", '"t": 2.0', '"t": 2.5')
    assert main(["campaign", "replay", "campaign", "3"]) == 1
    out = capsys.readouterr().out
    assert "different: the trace is not that of run 3" in out
    assert re.search(r"record \d+: `behavior.end` at 2.0 s: `t` was 2.5, is 2.0\n", out)
    assert main(["campaign", "replay", "campaign", "3", "--record-video"]) == 2
    assert "needs a simulator, and the campaign has none" in capsys.readouterr().err
    assert main(["campaign", "replay", "campaign", "1"]) == 1
    assert "did not keep its trace" in capsys.readouterr().out


def test_verdicts_are_compared_on_the_real_clock(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change(Path("main.osc"), "elapsed.2s.", "elapsed(0s)")
    command = ["campaign", "run", "main.osc", "--set", "name='x'", "--clock", "real", "-o", "real", "-j", "1"]
    assert main(command) == 1
    assert main(["campaign", "replay", "real", "3"]) == 0
    assert "the same verdict as run 3, failed; times differ on the real clock" in capsys.readouterr().out


def test_changed_files_are_refused(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change(Path("main.osc"), "0.5", "0.7")
    assert main(["campaign", "replay", "campaign", "3"]) == 2
    assert "run 3 cannot be repeated: main.osc changed since it began" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("run", "message"),
    [
        ("9", "unknown run `9` of campaign"),
        ("abcdef01", "unknown run `abcdef01`"),
        ("run3", "invalid run `run3`: expected its number"),
    ],
)
def test_unknown_runs_are_refused(
    campaign: Path, run: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["campaign", "replay", "campaign", run]) == 2
    err = capsys.readouterr().err
    assert message in err and ("numbered up to 3" in err or run == "run3")


def row(number: int, id_: str, status: End, reason: str = "") -> Row:
    return Row(number, id_, number, 1, 1, status, reason=reason)


def test_only_failed_runs_are_made_simpler(tmp_path: Path) -> None:
    generate(tmp_path, 0)
    rows = [
        row(1, "aaaa1", End.PASSED), row(2, "aaaa2", End.FAILED), row(3, "bbbb3", End.ERROR, "no simulator"),
        row(4, "cccc4", End.IMPOSSIBLE), row(5, "dddd5", End.FAILED), row(6, "dddd5", End.FAILED),
    ]  # fmt: skip
    (tmp_path / RUNS / "worker.jsonl").write_text("".join(each.to_line() for each in rows))
    planned = [Planned(number, number, 1, 7, {}, "grid") for number in range(1, 7)]
    (tmp_path / ASKED).write_text("".join(each.to_line() for each in planned))
    assert find_failed(tmp_path, "2").planned == planned[1]
    assert find_run(tmp_path, "dddd").row.run == 5, "equal ids are equal runs"
    for text, message in (
        ("1", "run 1 of .* passed; expected a failed run"),
        ("3", r"run 3 of .* ended without a verdict \(error\): no simulator; expected a failed run"),
        ("4", "run 4 of .* did not begin: constraints exclude its values"),
        ("aaaa", "several runs have an id that begins with `aaaa`: runs 1, 2"),
        ("aaa", "unknown run `aaa`"),
    ):
        with pytest.raises(UsageError, match=message) as caught:
            find_failed(tmp_path, text)
    with pytest.raises(UsageError) as caught:
        find_failed(tmp_path, "1")
    assert caught.value.help == "failed runs: 2, 5, 6"


def record(**fields: Any) -> str:
    return json.dumps({"seq": 0, "t": 1.0, "wall": "2026", "kind": "log", **fields}) + "\n"


@pytest.mark.parametrize(
    ("now", "text"),
    [
        ([record(x=1), record(x=2, wall="2027")], None),
        ([record(x=1), record(x=3)], "`log` at 1.0 s: `x` was 2, is 3"),
        ([record(x=1), record(y=2, path="a/b")], "`log` of `a/b` at 1.0 s: `x` was 2, is null; `y` was null"),
        ([record(x=1), record(kind="end")], "`log` at 1.0 s before, `end` at 1.0 s now"),
        ([record(x=1)], "`log` at 1.0 s is only in the earlier trace"),
        ([record(x=1), record(x=2), record(kind="end")], "`end` at 1.0 s is only in the later trace"),
    ],
)
def test_differences_of_traces_are_described(tmp_path: Path, now: list[str], text: str | None) -> None:
    files = tmp_path / "then.jsonl", tmp_path / "now.jsonl"
    files[0].write_text(record(x=1) + record(x=2))
    files[1].write_text("".join(now))
    found = first_difference(*files)
    assert (found is None) == (text is None) == (digest_of(files[0]) == digest_of(files[1]))
    assert text is None or (found is not None and found.text.startswith(text))
    files[1].write_text("{}\n")
    with pytest.raises(UsageError, match=r"now\.jsonl:1: invalid record"):
        first_difference(*files)
