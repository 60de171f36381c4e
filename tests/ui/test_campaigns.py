"""Campaigns in pages: lists, results while they grow, kept runs, reports."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.client import ClientConnection

from seoro.campaign.store.folder import RUNS
from seoro.cli.main import main
from seoro.ui import campaign_reader
from seoro.ui.campaign_json import snapshot_of
from seoro.ui.campaign_reader import CampaignReader, KnownRuns
from tests.campaign.generated import generate, rows
from tests.ui.browsing import DEADLINE, Browser, next_frame

SCENARIO = """import osc.helpers
import osc.types

scenario main:
    noise: float with:
        keep(it in [0.0, 0.1, 0.2, 0.3])
    record(noise)
    do serial:
        wait elapsed(1s)
        compare(noise, "<", 0.25)
"""


@pytest.fixture(scope="module")
def campaign(folder: Path) -> Path:
    """Folder of a campaign with four runs, one of which failed."""
    (folder / "vary.osc").write_text(SCENARIO)
    command = [
        "campaign",
        "run",
        str(folder / "vary.osc"),
        "-o",
        str(folder / "vary"),
        "--clock",
        "virtual",
        "--jobs",
        "1",
    ]
    assert main(command) == 1
    return folder / "vary"


def until(socket: ClientConnection, fits: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    while True:
        found: dict[str, Any] = json.loads(socket.recv(DEADLINE))
        if fits(found):
            return found


def entry(browser: Browser, end: str) -> dict[str, Any]:
    found: list[dict[str, Any]] = browser.get("/api/campaigns")["campaigns"]
    return next(each for each in found if each["folder"].endswith(end))


def test_a_page_shows_a_campaign_and_its_kept_runs(browser: Browser, campaign: Path) -> None:
    listed = entry(browser, "/vary")
    assert (listed["done"], listed["counts"]["failed"], listed["status"], listed["problem"]) == (
        4,
        1,
        "ended",
        "",
    )
    with browser.socket(f"/api/campaign/{listed['id']}") as socket:
        found = until(socket, lambda found: not found["isReading"])
    assert found["id"] == listed["id"]
    assert found["counts"] == {"passed": 3, "failed": 1, "error": 0, "cancelled": 0}
    assert (found["rate"]["passed"], found["rate"]["failed"]) == (3, 1)
    (axis,) = found["axes"]
    assert axis["path"] == "noise"
    failed = {bucket["label"]: bucket["failed"] for bucket in axis["buckets"]}
    assert failed == {"0": 0, "0.1": 0, "0.2": 0, "0.3": 1}
    (failure,) = found["latest"]
    assert failure["status"] == "failed"
    assert failure["values"] == {"noise": 0.3}
    with browser.socket(f"/api/run/{failure['kept']}") as socket:
        frame, _ = next_frame(socket)
    assert frame["first"]
    with browser.socket("/api/runs") as socket:
        runs = json.loads(socket.recv(DEADLINE))["runs"]
    assert failure["kept"] not in [run["id"] for run in runs]
    report = browser.http.get(f"/api/campaign/{listed['id']}/report")
    assert report.headers["content-disposition"].startswith("attachment")
    assert "vary.osc: campaign</title>" in report.text


def test_new_rows_reach_a_page(browser: Browser, folder: Path) -> None:
    growing = folder / "growing"
    growing.mkdir()
    generate(growing, 3000)
    shard = growing / RUNS / "worker.jsonl"
    lines = shard.read_bytes().splitlines(keepends=True)
    shard.write_bytes(b"".join(lines[:2000]) + lines[2000][:40])
    with browser.socket(f"/api/campaign/{entry(browser, '/growing')['id']}") as socket:
        found = until(socket, lambda found: not found["isReading"])
        assert (found["done"], found["runs"]) == (2000, 3000)
        with shard.open("ab") as file:
            file.write(lines[2000][40:] + b"".join(lines[2001:]))
        found = until(socket, lambda found: found["done"] == 3000)
    assert sum(found["counts"].values()) == 3000
    assert found["rate"]["low"] < found["rate"]["share"] < found["rate"]["high"]
    assert sum(bucket["passed"] + bucket["failed"] for bucket in found["axes"][0]["buckets"]) == 3000


def test_unknown_and_broken_campaigns_say_so(browser: Browser, folder: Path) -> None:
    broken = folder / "broken"
    (broken / RUNS).mkdir(parents=True)
    (broken / "campaign.json").write_text("{}")
    listed = entry(browser, "/broken")
    assert "invalid at" in listed["problem"]
    shutil.rmtree(broken)
    assert browser.http.get("/api/campaign/c123/report").status_code == 404
    assert not [each for each in browser.get("/api/campaigns")["campaigns"] if each["folder"].endswith("/broken")]


def test_rows_are_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    generate(tmp_path, 500)
    reader = CampaignReader(tmp_path)
    assert sum(reader.read_new()) == (tmp_path / RUNS / "worker.jsonl").stat().st_size
    added = [row.to_line() for row in rows(503)][500:]
    with (tmp_path / RUNS / "other.jsonl").open("w") as file:
        file.writelines(added)
    assert sum(reader.read_new()) == len("".join(added))
    assert list(reader.read_new()) == []
    with (tmp_path / RUNS / "other.jsonl").open("a") as file:
        file.writelines(added)  # a run that was repeated after its worker had died
    assert sum(reader.read_new()) == len("".join(added))
    assert reader.summary.runs == 503
    first = snapshot_of(reader, lambda row: None)
    again = CampaignReader(tmp_path)
    list(again.read_new())
    assert snapshot_of(again, lambda row: None) == first
    shutil.rmtree(tmp_path / RUNS)
    generate(tmp_path, 20)
    list(reader.read_new())
    assert reader.summary.runs == 20


def test_the_latest_failures_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign_reader, "MOST_LATEST", 3)
    generate(tmp_path, 2000)
    reader = CampaignReader(tmp_path)
    list(reader.read_new())
    found = [row.run for row in reader.latest]
    assert len(found) == 3
    assert found == sorted(found, reverse=True)


def test_numbers_of_runs_are_known_in_any_order() -> None:
    known = KnownRuns()
    assert [known.add(run) for run in (2, 1, 2, 5, 3, 4, 5, 1, 10**17)] == [
        *(True, True, False, True, True, True, False, False, True)
    ]
