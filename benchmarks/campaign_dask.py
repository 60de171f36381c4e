"""Campaign on a Dask cluster whose workers are killed: `python -m benchmarks.campaign_dask`.

It prints the distinct rows, the runs that were made again, and the processor time of all processes, also for the
same campaign on this machine alone. Each Dask worker starts a pool, which takes as long as many short runs. So the
time of further runs is printed, too: of those after the first third. The load of the machine changes processor
times by up to a factor of two.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from threading import Thread
from typing import Final

from seoro.campaign.runs import Row
from seoro.campaign.store.folder import RUNS, read_rows

SCENARIO: Final = """import osc.types
import osc.helpers

scenario waits:
    pause: time with:
        keep(it in [1s, 2s, 3s, 4s, 5s, 6s, 7s, 8s])
    load: float with:
        keep(it in [0.0..1.0])
    record(load)
    do serial:
        serial:
            wait elapsed(pause)
        with:
            repeat({waits})
        compare(load, "<", 0.9)
"""
AT_THE_END: Final = 20  # runs, during which workers begin to idle
PERIOD: Final = 0.5  # [s] between checks of the progress
QUIET: Final = {  # as in the documentation
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
}
_SUBREAPER: Final = 36  # PR_SET_CHILD_SUBREAPER, so that children of killed workers are counted


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=20)
    parser.add_argument("--killed", type=int, default=5)
    parser.add_argument("--waits", type=int, default=1, help="of a run; 700 take about 100 ms")
    options = parser.parse_args()
    ctypes.CDLL(None).prctl(_SUBREAPER, 1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "waits.osc").write_text(SCENARIO.format(waits=options.waits))
        before = _cpu()
        campaign = _campaign(folder, "here", options.runs, "--jobs", "2")
        further_here = _further(campaign, folder / "here", options.runs)
        _reap()
        here = _cpu() - before
        with _cluster(folder, options.workers) as (address, workers, started):
            campaign = _campaign(folder, "out", options.runs, "--dask", address)
            killing = Thread(target=_kill_during, args=(campaign, workers[: options.killed], folder, options.runs))
            killing.start()
            further = _further(campaign, folder / "out", options.runs)
            killing.join()
        on_dask = _cpu() - before - here
        rows = list(read_rows(folder / "out"))
        again = _made_again(folder, rows)
    distinct = len({row.run for row in rows})
    print(f"{distinct:,} distinct runs of {options.runs:,}; {options.killed} of {options.workers} workers killed")
    print(f"runs that were made again: {again} ({again / options.runs:.2%})")
    print(f"processor time on this machine: {here:.0f} s, {1e3 * here / options.runs:.1f} ms a run")
    work = on_dask - started
    print(f"on Dask: {work:.0f} s, {1e3 * work / options.runs:.1f} ms a run; their start: {started:.0f} s")
    print(f"beyond this machine: {work / here - 1:.1%}")
    print(f"further runs: {1e3 * further_here:.1f} ms here, {1e3 * further:.1f} ms on Dask")
    print(f"beyond this machine: {further / further_here - 1:.1%}")


def _campaign(folder: Path, out: str, runs: int, *place: str) -> subprocess.Popen[bytes]:
    options = ["--strategy", "random", "--runs", str(runs), "--seed", "1", "--clock", "virtual", "--keep", "none"]
    command = [
        sys.executable,
        "-m",
        "seoro",
        "campaign",
        "run",
        "waits.osc",
        *options,
        "-o",
        out,
        *place,
    ]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL)


@contextmanager
def _cluster(folder: Path, number: int) -> Iterator[tuple[str, list[subprocess.Popen[bytes]], float]]:
    """Start a scheduler and workers; yields its address, the workers, and the processor time of the start [s]."""
    file, before = folder / "scheduler.json", _cpu()
    with ExitStack() as stack:
        scheduler = _dask("dask_scheduler", folder, "--port", "0", "--scheduler-file", str(file))
        stack.callback(_end, scheduler)
        _wait(file.exists)
        local = ("--local-directory", str(folder / "dask"))
        options = ("--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", *local)
        workers = [_dask("dask_worker", folder, *options) for _ in range(number)]
        for worker in workers:
            stack.callback(_end, worker)
        address = json.loads(file.read_text())["address"]
        count = f"import distributed; distributed.Client({address!r}).wait_for_workers({number})"
        subprocess.run([sys.executable, "-c", count], check=True)
        yield address, workers, _cpu() - before + sum(map(_cpu_of, [scheduler, *workers]))
    _reap()


def _dask(program: str, folder: Path, *options: str) -> subprocess.Popen[bytes]:
    command = [
        sys.executable,
        "-m",
        f"distributed.cli.{program}",
        "--no-dashboard",
        "--host",
        "127.0.0.1",
        *options,
    ]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL, env=os.environ | QUIET)


def _kill_during(
    campaign: subprocess.Popen[bytes], workers: list[subprocess.Popen[bytes]], folder: Path, runs: int
) -> None:
    """Kill workers one after another, equally distributed over the campaign."""
    for number, worker in enumerate(workers, start=1):
        wanted = runs * number // (len(workers) + 1)
        _wait(lambda wanted=wanted: _lines(folder / "out" / RUNS) >= wanted or campaign.poll() is not None)  # type: ignore[misc]
        worker.kill()


def _further(campaign: subprocess.Popen[bytes], folder: Path, runs: int) -> float:
    """Wait for a campaign; returns the processor time of a run after the first third [s]."""
    taken: list[tuple[int, float]] = []
    for wanted in (runs // 3, runs - AT_THE_END):
        _wait(lambda wanted=wanted: _lines(folder / RUNS) >= wanted or campaign.poll() is not None)  # type: ignore[misc]
        taken.append((_lines(folder / RUNS), _cpu_of_all()))
    campaign.wait()
    (first, before), (last, after) = taken
    return (after - before) / max(1, last - first)


def _cpu_of_all() -> float:
    """Return the processor time of all ended and running processes below this one [s]."""
    parents, times = dict[int, int](), dict[int, float]()
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = path.read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
            parents[int(path.parent.name)] = int(fields[1])
            times[int(path.parent.name)] = sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
    below = {os.getpid()}
    while new := {each for each, parent in parents.items() if parent in below} - below:
        below |= new
    return _cpu() + sum(times[each] for each in below - {os.getpid()})


def _made_again(folder: Path, rows: Sequence[Row]) -> int:
    """Return the number of rows that killed workers have made, and not sent."""
    sent = Counter(row.worker for row in rows)
    left = Counter(
        Row.from_line(line).worker
        for runs in (folder / "dask").rglob(RUNS)
        for path in runs.glob("*.jsonl")
        for line in path.read_bytes().splitlines()
    )
    return sum(number - sent[worker] for worker, number in left.items())


def _lines(folder: Path) -> int:
    return sum(path.read_bytes().count(b"\n") for path in folder.glob("*.jsonl"))


def _wait(condition: Callable[[], bool]) -> None:
    while not condition():
        time.sleep(PERIOD)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGINT)
    process.wait()


def _reap() -> None:
    """Wait for all children, also for those of killed workers."""
    with suppress(ChildProcessError):
        while os.wait():
            pass


def _cpu() -> float:
    """Return the processor time of all ended children, with their children [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _cpu_of(process: subprocess.Popen[bytes]) -> float:
    """Return the processor time of a running process [s]."""
    fields = Path(f"/proc/{process.pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
