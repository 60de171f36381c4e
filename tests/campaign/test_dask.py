"""Campaigns on Dask clusters, whose workers are in this process or real ones."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

import seoro.campaign as sc
from seoro.campaign.runs import OF_THE_MACHINE, Row
from seoro.errors import BackendError, UsageError
from tests.campaign.generated import VARIED as TEXT
from tests.campaign.test_campaigns import rows_so_far, start, table
from tests.integration.conftest import wait_until

distributed = pytest.importorskip("distributed")
tasks = pytest.importorskip("seoro.campaign.dask.tasks")
ANY_PORT = pytest.importorskip("seoro.campaign.dask.engine").ANY_PORT

HANGING = """import osc.helpers
scenario main:
    noise: float with:
        keep(it in [0.0..0.2])
    do wait elapsed(1h)
"""


@pytest.fixture
async def cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Any]:
    """A cluster of two workers in this process, and a scenario in the working directory."""
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    opened = distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        dashboard_address=None,
        scheduler_kwargs={"dashboard_address": ANY_PORT},
        asynchronous=True,
        local_directory=str(tmp_path / "dask"),
    )
    async with opened as running:
        yield running


def rows_of(folder: str) -> list[tuple[object, ...]]:
    """Return the rows of a campaign, without columns of the machine."""
    names = [name for name in Row.__match_args__ if name not in OF_THE_MACHINE]
    return [tuple(getattr(row, name) for name in names) for row in sc.read(folder).rows()]


async def test_rows_are_those_of_this_machine(cluster: Any, tmp_path: Path) -> None:
    for folder, place in (("out", {"dask": cluster.scheduler_address}), ("here", {"jobs": 1})):
        options: Any = {"strategy": sc.Uniform(), "runs": 60, "seed": 5, "clock": "virtual", "folder": folder}
        async with sc.start("main.osc", **options, **place) as campaign:
            await campaign.wait()
    assert rows_of("out") == rows_of("here") and len(rows_of("out")) == 60
    assert [path.name for path in Path("out/runs").iterdir()] == ["dask.jsonl"], "a shard of its own"
    rows = list(sc.read("out").rows())
    assert all(row.worker and row.host for row in rows)
    failed = [row for row in rows if row.status is sc.End.FAILED]
    assert failed and all((Path("out") / row.folder / "trace.jsonl").stat().st_size for row in failed)
    assert tasks._hosts == {} and not list((tmp_path / "dask").rglob("campaign.json")), "nothing is left"


async def test_a_stopped_campaign_stops_its_runs(cluster: Any, tmp_path: Path) -> None:
    Path("main.osc").write_text(HANGING)
    async with sc.start(
        "main.osc", strategy=sc.Uniform(), runs=9, seed=5, folder="out", dask=cluster.scheduler_address
    ) as campaign:
        async with distributed.Client(cluster.scheduler_address, asynchronous=True) as client:
            while not tasks._hosts or not any((await client.processing()).values()):
                await asyncio.sleep(0)
        campaign.stop()
        await campaign.wait()
    assert rows_of("out") == [] and tasks._hosts == {}


async def test_other_versions_of_seoro_are_refused(cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tasks, "__version__", "0.0.1")
    with pytest.raises(BackendError, match=r"it has seoro 0\.0\.1, the campaign"):
        async with sc.start(
            "main.osc", strategy=sc.Uniform(), runs=9, folder="out", dask=cluster.scheduler_address
        ) as campaign:
            await campaign.wait()
    assert not Path("out").exists(), "nothing has begun"


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("local:0", "expected `local:N`"),
        ("tcp://127.0.0.1:1", "cannot reach a Dask scheduler at tcp://127.0.0.1:1"),
    ],
)
async def test_places_without_a_cluster_are_refused(
    address: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("seoro.campaign.dask.engine.CONNECT_TIMEOUT", 0.2)
    Path("main.osc").write_text(TEXT)
    with pytest.raises(UsageError, match=message):
        async with sc.start("main.osc", strategy=sc.Uniform(), runs=9, folder="out", dask=address):
            pass


@contextmanager
def cluster_of_processes(number: int, folder: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Start a Dask scheduler and workers in processes of their own; yields its address, and the workers."""
    file = folder / "scheduler.json"
    own = ["--no-dashboard", "--host", "127.0.0.1"]
    parts = [
        ["dask_scheduler", *own, "--dashboard-address", ANY_PORT, "--port", "0", "--scheduler-file", str(file)]
    ]
    parts += [["dask_worker", "--scheduler-file", str(file), *own, "--nthreads", "1", "--no-nanny"]] * number
    with ExitStack() as stack:
        started = []
        for module, *options in parts:
            command = [sys.executable, "-m", f"distributed.cli.{module}", *options]
            process = subprocess.Popen(command, stderr=subprocess.DEVNULL, cwd=folder)
            stack.callback(process.wait)
            stack.callback(process.kill)
            started.append(process)
            wait_until(file.exists, 60.0)
        yield json.loads(file.read_text())["address"], started[1:]


@pytest.mark.more
def test_no_row_is_lost_when_workers_die(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    random = ("--strategy", "random", "--clock", "virtual", "--seed", "5", "-o", "out", "--keep", "none")
    with cluster_of_processes(3, tmp_path) as (address, workers):
        process = start("run", "main.osc", *random, "--runs", "1000", "--dask", address)
        try:
            for worker, ended in zip(workers, (50, 200), strict=False):
                wait_until(lambda ended=ended: rows_so_far() > ended, 60.0)  # type: ignore[misc]
                worker.kill()
            assert process.wait(120) == 1
        finally:
            process.kill()
            process.wait()
    rows = table()
    assert [int(row["run"]) for row in rows] == list(range(1, 1001))
    assert {row["status"] for row in rows} == {"passed", "failed"}, "no run is an error"
