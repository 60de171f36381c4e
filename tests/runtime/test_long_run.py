"""Long runs: constant memory, and constant costs for each second.

`SEORO_LONG_RUN` is the duration of the long run [s of the virtual clock]; by default, a week.
"""

from __future__ import annotations

import asyncio
import gc
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from seoro.embed import load, prepare
from seoro.embed.options import Options

DAY = 24 * 3600.0
PAGE = os.sysconf("SC_PAGE_SIZE")
# One leg per second, with events, conditions, random values, cancellations and other short-lived objects.
PATROL = """
import osc.types
import osc.helpers

scenario leg:
    number: int
    event reached(number: int)
    do serial:
        wait elapsed(0.5s)
        emit reached(number)

scenario main:
    event alarm
    event received is @alarm if legs % 2 == 0
    event reported(level: int)
    var legs: int = 0
    var seen: int = sample(legs, every(1s), 0)
    on @current.reached as r if r.number % 3 == 0:
        emit reported(r.number)
    on @reported:
        emit alarm
    do parallel:
        serial:
            current: leg(legs)
            increment(legs)
            one_of:
                wait @received
                wait elapsed(0.5s)
        with:
            repeat()
        serial:
            wait @current.end
            watch: parallel:
                wait rise(legs % 5 == 0)
                wait elapsed([0.1s..0.3s])
            with:
                failure_is_success()
                timeout(0.4s)
        with:
            repeat()
    with:
        until elapsed({seconds}s)
"""
TICKS = """
import osc.types
import osc.helpers

scenario main:
    event tick is every(1s, offset: 1s)
    event passed(post: int)
    event alarm
    var seconds: int = sample(seconds + 1, @tick, 0)
    on @passed as p if p.post == 3:
        emit alarm
    do serial:
        wait elapsed(1s)
        emit passed(seconds % 4)
    with:
        until elapsed({seconds}s)
        repeat()
"""


@pytest.fixture(autouse=True)
def leftovers() -> None:
    """Replaces the check of other tests, which keeps the tasks of a run in memory."""


@dataclass(eq=False)
class Gauge:
    """An observer that measures at some times of a run.

    Args:
        times: Times of the measurements [s].
    """

    times: Sequence[float]
    blocks: list[int] = field(default_factory=list)  # of memory that Python has given out
    resident: list[int] = field(default_factory=list)  # bytes of the process
    cpu: list[float] = field(default_factory=list)  # [s] of the processor

    def record(self, record: dict[str, Any]) -> None:
        """Measure at the chosen times."""
        if len(self.cpu) < len(self.times) and record["t"] >= self.times[len(self.cpu)]:
            gc.collect()
            self.blocks.append(sys.getallocatedblocks())
            self.resident.append(int(Path("/proc/self/statm").read_text().split()[1]) * PAGE)
            self.cpu.append(time.process_time())


def measure(path: Path, text: str, seconds: float, parts: Sequence[float]) -> Gauge:
    """Run a scenario without keeping its trace, and measure after parts of it."""
    path.write_text(text.format(seconds=seconds))
    gauge = Gauge([part * seconds for part in parts])

    async def run() -> None:
        options = Options(seed=0, clock="virtual", observers=[gauge], keep_trace=False)
        async with prepare(load(path), options) as started, started.running():
            assert (await started.result()).passed

    asyncio.run(run())
    assert len(gauge.cpu) == len(parts)
    return gauge


@pytest.mark.slow
@pytest.mark.parametrize("text", [PATROL, TICKS], ids=["patrol", "ticks"])
def test_finished_behaviors_are_freed_from_memory(text: str, tmp_path: Path) -> None:
    gauge = measure(tmp_path / "test.osc", text, 3000, (0.6, 0.99))
    # Python keeps freed tuples and the like for later, some hundreds; one object a second would be 1,170.
    assert gauge.blocks[1] - gauge.blocks[0] < 700


@pytest.mark.slow
def test_a_week_takes_constant_memory_and_linear_time(tmp_path: Path) -> None:
    seconds = float(os.environ.get("SEORO_LONG_RUN", 7 * DAY))
    gauge = measure(tmp_path / "test.osc", TICKS, seconds, (0.1, 0.2, 0.9, 0.999))
    assert gauge.resident[3] - gauge.resident[0] < 2**20
    assert gauge.blocks[3] - gauge.blocks[0] < 1000
    first, last = gauge.cpu[1] - gauge.cpu[0], gauge.cpu[3] - gauge.cpu[2]
    assert last < 1.5 * first


@pytest.mark.slow
def test_the_command_line_does_not_hold_the_trace_in_memory(tmp_path: Path) -> None:
    path, peaks = tmp_path / "test.osc", []
    for seconds in (100, 2000):
        path.write_text(PATROL.format(seconds=seconds))
        seoro = str(Path(sys.executable).with_name("seoro"))
        command = [seoro, "exec", str(path), "--clock", "virtual", "--seed", "0", "-o", str(tmp_path / "out")]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        peaks.append(used.ru_maxrss)  # [KiB]
    size = (tmp_path / "out" / "trace.jsonl").stat().st_size if (tmp_path / "out").is_dir() else 0
    assert size > 10 * 2**20
    assert peaks[1] - peaks[0] < 4 * 2**10
