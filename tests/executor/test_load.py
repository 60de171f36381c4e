"""Benchmark of executors under load, with fewer runs: no records are lost, and memory is constant."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "executor_load.py"


def run(*arguments: str, timeout: float) -> str:
    """Return the output of the successful benchmark."""
    command = [sys.executable, str(SCRIPT), *arguments]
    ran = subprocess.run(command, check=False, capture_output=True, text=True, timeout=timeout)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


@pytest.mark.slow
def test_many_clients_lose_no_run_and_record() -> None:
    run("--queued", "8", "--at-once", "4", "--watchers", "3", "--runs", "0", timeout=120.0)


@pytest.mark.slow
def test_memory_is_constant_after_a_thousand_runs() -> None:
    # Until then, caches of the executor fill; it starts with half of its final memory.
    shown = run("--queued", "0", "--at-once", "0", "--watchers", "0", "--runs", "3000", timeout=900.0)
    first, *_, last = re.findall(r"executor ([\d.]+) MiB, process that forks ([\d.]+) MiB", shown)
    for before, after in zip(first, last, strict=True):
        assert float(after) < float(before) + 3.0
