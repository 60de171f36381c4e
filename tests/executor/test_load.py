"""The benchmark of executors under load, with fewer runs: nothing is lost, and memory stays what it was."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "executor_load.py"


def run(*arguments: str, timeout: float) -> str:
    """What the benchmark prints, which has found nothing wrong."""
    command = [sys.executable, str(SCRIPT), *arguments]
    ran = subprocess.run(command, check=False, capture_output=True, text=True, timeout=timeout)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


@pytest.mark.slow
def test_a_crowd_loses_nothing() -> None:
    run("--queued", "8", "--at-once", "4", "--watchers", "3", "--runs", "0", timeout=120.0)


@pytest.mark.slow
def test_memory_stays_what_it_was_after_the_first_thousand_runs() -> None:
    # Until then, caches of the executor fill: it begins with half of what it has in the end.
    shown = run("--queued", "0", "--at-once", "0", "--watchers", "0", "--runs", "3000", timeout=900.0)
    first, *_, last = re.findall(r"executor ([\d.]+) MiB, process that forks ([\d.]+) MiB", shown)
    for before, after in zip(first, last, strict=True):
        assert float(after) < float(before) + 3.0
