"""Processes that die: they count as dead before they are gone."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from seoro.campaign.work.processes import is_dying, processor_time


def test_a_living_process_has_a_processor_time() -> None:
    time = processor_time(os.getpid())
    assert time is not None and time > 0.0
    assert processor_time(None) is None


def test_a_killed_process_counts_as_dead_before_its_end_is_fetched() -> None:
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    assert processor_time(process.pid) is not None
    process.kill()
    assert processor_time(process.pid) is None
    assert process.wait() == -signal.SIGKILL
    assert processor_time(process.pid) is None
    process.communicate()


@pytest.mark.parametrize(
    ("position", "value", "expected"),
    [(0, "S", False), (0, "Z", True), (6, str(0x400004), True), (28, "256", True), (28, "2", False)],
)
def test_a_process_that_is_about_to_die_is_known(position: int, value: str, expected: bool) -> None:
    fields = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
    fields[position] = value
    assert is_dying(fields) == expected
