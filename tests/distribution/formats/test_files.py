"""Files of each released version are read by the commands of today."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

import seoro.campaign as sc
from seoro.cli.main import main
from seoro.ui.server import SiteOptions
from tests.distribution.formats.make import FORMATS
from tests.ui.browsing import opened
from tests.ui.conftest import serving


@pytest.fixture(params=sorted(path.name for path in FORMATS.iterdir()))
def files(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of the files of a version, the working folder."""
    copied = Path(shutil.copytree(FORMATS / request.param, tmp_path / "files"))
    plan = copied / "campaign" / "campaign.json"
    plan.write_text(re.sub(r'"root": "[^"]*"', f'"root": {json.dumps(str(copied))}', plan.read_text()))
    monkeypatch.chdir(copied)
    return copied


@pytest.mark.parametrize(
    "command",
    [
        "trace trace.jsonl",
        "trace --summary trace.jsonl",
        "trace --why 20 trace.jsonl",
        "trace --perfetto timeline.json trace.jsonl",
        "trace --mcap recording.mcap trace.jsonl",
        "report trace.jsonl -o page.html",
        "report run",
        "compare trace.jsonl trace.jsonl",
        "accept trace.jsonl deliver.osc",
        "accept run/trace.jsonl load.osc",
        "redact trace.jsonl redacted.jsonl",
        "replay trace.jsonl deliver.osc",
        "campaign status campaign",
        "campaign coverage campaign",
        "campaign report campaign",
        "runs prune --older 1d --dry-run run",
    ],
)
def test_a_command_reads_it(files: Path, command: str, capfd: pytest.CaptureFixture[str]) -> None:
    status = main(command.split())
    printed = capfd.readouterr()
    assert status == 0, printed.out + printed.err
    assert "Traceback" not in printed.err


def test_a_replayed_run_has_the_same_behaviors(files: Path) -> None:
    assert main(["replay", "trace.jsonl", "deliver.osc", "--trace", "again.jsonl"]) == 0
    before, after = (
        [
            (each["t"], each["kind"], each.get("path"), each.get("status"))
            for each in map(json.loads, (files / name).read_text().splitlines())
        ]
        for name in ("trace.jsonl", "again.jsonl")
    )
    assert after == before


def test_the_rows_of_a_campaign_are_read(files: Path) -> None:
    results = sc.read(files / "campaign")
    assert (results.rate().passed, results.rate().failed) == (4, 2)
    failed = [row for row in results.rows() if row.status is sc.End.FAILED]
    assert all("`compare` failed" in row.reason for row in failed)
    assert all(float(str(row.values["load"])) > 15.0 for row in failed)


def test_a_campaign_is_compared_run_by_run(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["campaign", "compare", "campaign", "campaign"])
    assert "6 equal to the bit" in capsys.readouterr().out


def test_a_run_of_a_campaign_is_repeated(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    number = next(row.run for row in sc.read(files / "campaign").rows() if row.status is sc.End.FAILED)
    assert main(["campaign", "replay", "campaign", str(number)]) in (0, 1)  # 1: it differs from that version
    assert "`compare` failed" in capsys.readouterr().err
    assert (files / "campaign" / "replayed").exists()


def test_pages_list_it(files: Path, tmp_path: Path) -> None:
    with serving(SiteOptions((files,), tmp_path / "state")) as served, opened(served.access) as browser:
        run = browser.run(lambda each: each["folder"] == str(files / "run"))
        assert run["status"] == "passed"
        (campaign,) = browser.get("/api/campaigns")["campaigns"]
        assert campaign["counts"].items() >= {"passed": 4, "failed": 2}.items()
