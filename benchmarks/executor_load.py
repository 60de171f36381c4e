"""Executor under load: many queued runs, many simultaneous runs, many watchers, thousands of consecutive runs.

    python benchmarks/executor_load.py [--queued N] [--at-once N] [--watchers N] [--runs N]

Three executors on this machine, one after the other. The first has a queue of short runs. The second has many
simultaneous busy runs on the virtual clock, while watchers follow all of them, and the list of runs is requested
continuously. Every record must arrive exactly once. The third executes short runs one after the other, and the
memory of the executor and of its fork server is measured. The exit status is 1 if a record was lost or duplicated.
"""

from __future__ import annotations

import argparse
import asyncio
import multiprocessing
import os
import statistics
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

from processes import Executor, children, executor
from startup import HELLO

import seoro
from seoro.bundle.pack import Bundle, pack
from seoro.client.runs import RemoteRun
from seoro.embed.options import Options

NAME = "load"
LISTED = 100  # runs in an answer
ASK_PERIOD = 0.05  # [s]
BATCH = 50  # runs that wait at a time while memory is looked at
SETTLED = 0.34  # share of the runs after which memory should be constant
GOAL_LIST = 0.100  # [s]
BUSY = """import osc.helpers
scenario busy:
    event tick
    on every(10ms):
        emit tick
    do serial:
        wait elapsed(20s)
"""


def memory(process: int, *, all_of_it: bool = False) -> float:
    """Return the memory of a process [MiB], with its part or all of shared memory; 0 if it has ended."""
    counted = "Rss:" if all_of_it else "Pss:"
    with suppress(OSError):
        for line in Path(f"/proc/{process}/smaps_rollup").read_text().splitlines():
            if line.startswith(counted):
                return int(line.split()[1]) / 1024.0
    return 0.0


@dataclass
class Seen:
    """Observations of watchers and clients."""

    records: int = 0
    broken: list[str] = field(default_factory=list)
    answers: list[float] = field(default_factory=list)  # [s]
    at_once: int = 0
    memory: float = 0.0  # of all processes, at most [MiB]


async def watch(client: seoro.Client, runs: Sequence[RemoteRun], seen: Seen) -> None:
    """Follow runs one after the other, as another client than the one that submitted them."""
    for run in runs:
        numbers = [record["seq"] async for record in (await client.run(run.id, NAME)).records()]
        seen.records += len(numbers)
        if numbers != list(range(len(numbers))) or not numbers:
            seen.broken.append(f"run {run.id}: its records are numbered {numbers[:3]}...{numbers[-3:]}")


def ask(endpoint: str, end: Connection) -> None:
    """Request the list of runs continuously in a separate process; report the times at the end."""

    async def ask_on() -> list[float]:
        found = []
        async with seoro.Client(endpoint) as client:
            while not end.poll():
                began = time.perf_counter()
                await client.runs(NAME, LISTED)
                found.append(time.perf_counter() - began)
                await asyncio.sleep(ASK_PERIOD)
        return found

    end.send(asyncio.run(ask_on()))


@contextmanager
def asking(endpoint: str, seen: Seen) -> Iterator[None]:
    """Request the list of runs repeatedly during the block."""
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=ask, args=(endpoint, theirs))
    process.start()
    theirs.close()  # it ends with the process
    try:
        yield
    finally:
        ours.send(None)
        seen.answers += ours.recv()
        process.join()


async def look(client: seoro.Client, executor: Executor, seen: Seen) -> None:
    """Observe the number of active runs and the memory of all processes."""
    while True:
        [status] = await client.describe(NAME)
        seen.at_once = max(seen.at_once, status.info.running)
        template = executor.template
        processes = [executor.process, template, *children(template)]
        seen.memory = max(seen.memory, sum([memory(each) for each in processes]))
        await asyncio.sleep(1.0)


@asynccontextmanager
async def clients(endpoint: str, count: int) -> AsyncIterator[list[seoro.Client]]:
    """Open clients, each with its own connection."""
    async with AsyncExitStack() as stack:
        yield [await stack.enter_async_context(seoro.Client(endpoint)) for _ in range(count)]


async def crowd(executor: Executor, bundle: Bundle, count: int, watchers: int, seen: Seen) -> float:
    """Submit runs simultaneously and watch them to their ends; return the duration [s]."""
    async with clients(executor.endpoint, watchers + 2) as (looking, submitting, *watching):
        other = asyncio.create_task(look(looking, executor, seen))
        began = time.perf_counter()
        runs = [await submitting.submit_bundle(NAME, bundle) for _ in range(count)]
        async with asyncio.TaskGroup() as group:
            for number, client in enumerate(watching):
                group.create_task(watch(client, runs[number::watchers], seen))
        took = time.perf_counter() - began
        other.cancel()
        for run in runs:
            if not (verdict := await run.result()).passed:
                seen.broken.append(f"run {run.id}: {verdict.reason}")
    return took


async def follow_each_other(executor: Executor, bundle: Bundle, count: int) -> list[tuple[int, float, float]]:
    """Execute runs one after another; return the memory of both processes after some of them."""
    found = []
    async with seoro.Client(executor.endpoint) as client:
        for done in range(0, count, BATCH):
            runs = [await client.submit_bundle(NAME, bundle) for _ in range(min(BATCH, count - done))]
            for run in runs:
                await run.result()
            # All of it, without parts shared with other processes.
            ours, templates = (memory(each, all_of_it=True) for each in (executor.process, executor.template))
            found.append((done + len(runs), ours, templates))
    return found


def report(title: str, count: int, took: float, seen: Seen) -> None:
    """Print the observations of a crowd."""
    answers = sorted(seen.answers)
    half, most = statistics.median(answers), answers[int(0.99 * len(answers))]
    print(f"{title}: {count} runs in {took:.1f} s, {seen.at_once} at once at most, {seen.memory:.0f} MiB in all")
    print(f"  {seen.records} records watched, {len(seen.broken)} runs with some lost or doubled, or not passed")
    print(
        f"  list of {LISTED} runs, {len(answers)} times: p50 {1000 * half:.1f} ms, p99 {1000 * most:.1f} ms",
        end="",
    )
    print(f"   wanted: {1000 * GOAL_LIST:.0f} ms at most")
    for line in seen.broken[:5]:
        print(f"  {line}")


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure an executor under load.")
    parser.add_argument("--queued", type=int, default=200)
    parser.add_argument("--at-once", type=int, default=50)
    parser.add_argument("--watchers", type=int, default=20)
    parser.add_argument("--runs", type=int, default=5000)
    options = parser.parse_args()
    broken = 0
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        Path("hello.osc").write_text(HELLO)
        Path("busy.osc").write_text(BUSY)
        hello = pack(seoro.load("hello.osc"), Options())
        busy = pack(seoro.load("busy.osc"), Options(clock="virtual"))
        crowds = (("waiting", hello, options.queued, 1), ("at once", busy, options.at_once, options.at_once))
        for title, bundle, count, jobs in crowds:
            if count:
                place = Path(name, title.replace(" ", "_"))
                place.mkdir()
                with executor(place, NAME, jobs) as running:
                    seen = Seen()
                    with asking(running.endpoint, seen):
                        took = asyncio.run(crowd(running, bundle, count, options.watchers, seen))
                report(title, count, took, seen)
                broken += len(seen.broken)
        if options.runs:
            place = Path(name, "chain")
            place.mkdir()
            with executor(place, NAME) as running:
                began = time.perf_counter()
                found = asyncio.run(follow_each_other(running, hello, options.runs))
                took = time.perf_counter() - began
            print(f"one after another: {options.runs} runs in {took:.0f} s")
            for at in sorted({int(SETTLED * (len(found) - 1)), len(found) // 2, len(found) - 1}):
                done, executors, templates = found[at]
                print(f"  after {done} runs: executor {executors:.1f} MiB, process that forks {templates:.1f} MiB")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
