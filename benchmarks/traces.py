"""Cost of traces: per record in the run, on the disk, and in `seoro trace`.

    python benchmarks/traces.py

Prints microseconds for each record that a run hands on, with and without a file, and the time and memory in which
`seoro trace` shows a million records.
"""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from seoro.runtime.contracts.observers import Observer
from seoro.runtime.trace.jsonl import JsonLines
from seoro.runtime.trace.records import Trace

RECORDS = 200_000
FIELDS = {
    "parent": 3,
    "type": "action",
    "name": "robot.nav_to_pose",
    "path": "main/serial[0]/x[1]",
    "source": "a.osc:1:9",
}
LOOK = """
import pathlib, sys
from seoro.cli.main import main
main(sys.argv[1:])
print(*[line for line in pathlib.Path("/proc/self/status").open() if line.startswith("VmHWM")], file=sys.stderr)
"""


class Nobody:
    """Observes records and ignores them."""

    def record(self, record: dict[str, object]) -> None:
        """Do nothing."""


class Direct:
    """Writes records at once, as a run would without a thread."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", encoding="utf-8")

    def record(self, record: dict[str, object]) -> None:
        """Write one."""
        self._file.write(json.dumps(record, ensure_ascii=False) + "\n")


def hand_on(observer: Observer) -> float:
    """Return the time of a run for a record [s]."""
    failures: list[Exception] = []
    trace = Trace([observer], lambda: 0.0, failures.append)
    start = time.perf_counter()
    for number in range(RECORDS // 2):
        trace.record("behavior.start", id=number, **FIELDS)
        trace.record("behavior.end", id=number, status="succeeded", reason="")
    assert not failures
    return (time.perf_counter() - start) / RECORDS


def write(path: Path) -> None:
    """Write the records in a thread, and print the cost."""

    async def finish(lines: JsonLines) -> None:
        await lines.finish()

    with path.open("wb", buffering=0) as file:
        lines = JsonLines(file, str(path), most_waiting=RECORDS)
        print(f"written by a thread: {hand_on(lines) * 1e6:.1f} us", end="")
        start = time.perf_counter()
        asyncio.run(finish(lines))
        print(f", and {time.perf_counter() - start:.2f} s at the end for {RECORDS:,} records")


def look(path: Path, option: str) -> None:
    """Print the time and memory of `seoro trace` for a file."""
    start = time.perf_counter()
    command = [sys.executable, "-c", LOOK, "trace", str(path), option]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=True)
    took, memory = time.perf_counter() - start, done.stderr.split()[-2]
    print(f"seoro trace {option}: {took:.1f} s for a million records, {int(memory) / 1024:.0f} MB")


def main() -> None:
    """Measure."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "trace.jsonl"
        print(f"a record without a writer: {hand_on(Nobody()) * 1e6:.1f} us")
        print(f"written at once: {hand_on(Direct(path)) * 1e6:.1f} us")
        write(path)
        million = Path(folder) / "million.jsonl"
        with million.open("wb") as file:
            for _ in range(1_000_000 // RECORDS):
                file.write(path.read_bytes())
        for option in ("--kind=*", "--summary"):
            look(million, option)


if __name__ == "__main__":
    main()
