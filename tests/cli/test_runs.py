"""Pruning of folders of runs."""

from __future__ import annotations

import asyncio
import json
import os
import time
from pathlib import Path

import pytest

from seoro.bridges.executor import messages as wire
from seoro.cli.main import main
from seoro.executor.storage.store import Finished, open_store

DAY = 86_400.0  # [s]


def run_in(folder: Path, age: float, status: str = "passed", size: int = 1000) -> Path:
    """Make the results of a run that ended some days ago."""
    folder.mkdir(parents=True)
    end = [{"kind": "run.end", "status": status}] if status else []
    lines = [{"kind": "run.start", "pad": "x" * size}, *end]
    (folder / "trace.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    (folder / ".seoro-results").write_text("trace.jsonl\ntop_down.png\nframes\n../escape\n")
    (folder / "frames").mkdir()
    (folder / "frames" / "a.png").write_bytes(b"picture")
    when = time.time() - age * DAY
    os.utime(folder / "trace.jsonl", (when, when))
    return folder


@pytest.fixture
def results(tmp_path: Path) -> Path:
    root = tmp_path / "results"
    run_in(root / "old", 41)
    run_in(root / "deep" / "failed", 40, "failed")
    run_in(root / "new", 1)
    run_in(root / "active", 0.5, "")
    (root / "old" / "notes.txt").write_text("mine")
    (root / "data").mkdir()
    (root / "data" / "trace.jsonl").write_text("{}\n")  # of no run
    (root / "escape").write_text("")
    return root


def left(root: Path) -> set[str]:
    return {path.parent.relative_to(root).as_posix() for path in root.rglob("trace.jsonl")}


def test_old_runs_are_deleted_and_other_files_stay(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["runs", "prune", str(results), "--older", "30d"]) == 0
    assert left(results) == {"new", "active", "data"}
    assert [path.name for path in (results / "old").iterdir()] == ["notes.txt"]
    assert not (results / "deep" / "failed").exists()
    assert (results / "escape").exists()
    assert "deleted 2 of 4 runs, 2." in capsys.readouterr().out


def test_failed_runs_are_kept_on_request(results: Path) -> None:
    assert main(["runs", "prune", str(results), "--older", "30d", "--keep-failed"]) == 0
    assert left(results) == {"deep/failed", "new", "active", "data"}


def test_a_dry_run_deletes_nothing(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = left(results)
    assert main(["runs", "prune", str(results), "--older", "30d", "--dry-run"]) == 0
    assert left(results) == before
    assert "would delete 2 of 4 runs" in capsys.readouterr().out


def test_the_oldest_runs_are_deleted_until_the_rest_is_small(results: Path) -> None:
    assert main(["runs", "prune", str(results), "--larger", "3.5kB"]) == 0
    assert left(results) == {"deep/failed", "new", "active", "data"}


def test_kept_runs_of_campaigns_are_deleted(tmp_path: Path) -> None:
    campaign = tmp_path / "campaign"
    campaign.mkdir()
    (campaign / "campaign.json").write_text("{}")
    run_in(campaign / "kept" / "000001", 40)
    run_in(campaign / "kept" / "mine", 40)
    assert main(["runs", "prune", str(tmp_path), "--older", "30d"]) == 0
    assert [path.name for path in (campaign / "kept").iterdir()] == ["mine"]
    assert (campaign / "campaign.json").exists()


def test_links_are_not_followed(results: Path, tmp_path: Path) -> None:
    other = run_in(tmp_path / "elsewhere" / "run", 40)
    (results / "link").symlink_to(other.parent)
    (results / "old" / "top_down.png").symlink_to(results / "new" / "trace.jsonl")
    assert main(["runs", "prune", str(results), "--older", "30d"]) == 0
    assert (other / "trace.jsonl").exists()
    assert (results / "new" / "trace.jsonl").exists()
    assert not (results / "old" / "top_down.png").is_symlink()


def test_runs_of_executors_are_deleted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = ("a" * 32, "b" * 32)

    async def fill() -> None:
        with open_store(tmp_path) as store:
            for run, status in zip(runs, (wire.State.PASSED, wire.State.FAILED), strict=True):
                await store.add(submission(run))
                store.folder(run).path.mkdir(parents=True)
                await store.finish(run, Finished(status, "", b"", time.time() - 9 * DAY))

    asyncio.run(fill())
    assert main(["runs", "prune", str(tmp_path), "--older", "7d", "--keep-failed"]) == 0
    assert "deleted 1 of 2 runs" in capsys.readouterr().out
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [runs[1]]


def submission(run: str) -> wire.Submission:
    file = wire.BundleFile(path="main.osc", hash="0" * 64, size=1)
    options = wire.BundledOptions(overrides={}, grace=1.0)
    manifest = wire.Manifest(files=(file,), entry="main.osc", shown="main.osc", options=options)
    return wire.Submission(run=run, manifest=manifest)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "missing `--older` or `--larger`"),
        (("--older", "30"), "expected a duration"),
        (("--larger", "20"), "expected a size"),
    ],
)
def test_invalid_policies_are_refused(
    arguments: tuple[str, ...], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["runs", "prune", str(tmp_path), *arguments])
    except SystemExit as end:
        status = int(end.code or 0)
    assert status == 2
    assert message in capsys.readouterr().err
