"""The benchmark of executors under load, with few runs: nothing is lost, and memory stays what it was."""

import re
import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "executor_load.py"


def test_a_crowd_loses_nothing_and_memory_stays() -> None:
    arguments = ["--queued", "12", "--at-once", "6", "--watchers", "4", "--runs", "150"]
    command = [sys.executable, str(SCRIPT), *arguments]
    ran = subprocess.run(command, check=False, capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    first, *_, last = re.findall(r"executor ([\d.]+) MiB, process that forks ([\d.]+) MiB", ran.stdout)
    for before, after in zip(first, last, strict=True):
        assert float(after) < float(before) + 3.0
