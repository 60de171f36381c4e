"""Cost of running a scenario on an executor instead of locally, both on this machine.

    python benchmarks/network.py [--rounds N]

Prints the median wall time and processor time of a scenario of three lines, locally and on an executor. Also
prints the latency of a record from the run to a connected watcher.
"""

from __future__ import annotations

import argparse
import asyncio
import compileall
import os
import statistics
import sys
import tempfile
import time
from datetime import datetime
from pathlib import Path

from processes import executor
from startup import HELLO, measure

import seoro

NAME = "benchmark"
PAUSE = 1.0  # [s] after a run, in which the executor gets another process ready
GOAL_ROUND_TRIP, GOAL_RECORD = 0.150, 0.001  # [s]
PERIODS = (20, 5, 1)  # [ms] between records
RECORDS = 300  # of each
TICKS = """import osc.helpers
scenario ticks:
    event tick
    on every({period}ms):
        emit tick
    do serial:
        wait elapsed({duration}ms)
"""


def round_trips(file: Path, rounds: int) -> None:
    """Print how long the command takes."""
    command = [str(Path(sys.executable).with_name("seoro")), "exec", str(file)]
    commands = {"here": command, "on an executor": [*command, "--on", NAME]}
    times: dict[str, list[tuple[float, float]]] = {where: [] for where in commands}
    for _ in range(rounds):
        for where, each in commands.items():
            times[where].append(measure(each))
            time.sleep(PAUSE)
    medians = {
        where: [statistics.median(each) for each in zip(*taken, strict=True)] for where, taken in times.items()
    }
    print(f"{'':20} {'wall':>8} {'processor':>10}")
    for where, (wall, processor) in medians.items():
        print(f"{where:20} {wall:7.3f}s {processor:9.3f}s")
    more = medians["on an executor"][0] - medians["here"][0]
    print(f"{'more':20} {more:7.3f}s   wanted: less than {GOAL_ROUND_TRIP:.3f}s")


async def latencies(file: Path) -> list[float]:
    """Return the latencies of records [s]; both ends have the same clock."""
    found = []
    async with seoro.Client() as client:
        run = await client.submit(NAME, file)
        async for record in run.records():
            arrived = time.time()
            if record["kind"] == "event":
                found.append(arrived - datetime.fromisoformat(record["wall"]).timestamp())
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the cost of running a scenario on an executor.")
    parser.add_argument("--rounds", type=int, default=11)
    options = parser.parse_args()
    compileall.compile_dir(Path(seoro.__file__).parent, quiet=2)
    with tempfile.TemporaryDirectory() as name, executor(Path(name), NAME) as running:
        os.environ["SEORO_EXECUTOR"] = running.endpoint
        time.sleep(2.0 * PAUSE)
        hello = Path(name) / "hello.osc"
        hello.write_text(HELLO)
        round_trips(hello, options.rounds)
        print(f"a record, wanted: {1000 * GOAL_RECORD:.0f} ms at most")
        for period in PERIODS:
            ticks = Path(name) / f"ticks{period}.osc"
            ticks.write_text(TICKS.format(period=period, duration=period * RECORDS))
            taken = sorted(asyncio.run(latencies(ticks)))
            half, most = statistics.median(taken), taken[int(0.99 * len(taken))]
            print(f"  each {period:2} ms: p50 {1000 * half:.2f} ms, p99 {1000 * most:.2f} ms")


if __name__ == "__main__":
    main()
