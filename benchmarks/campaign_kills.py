"""Kills of processes of a campaign at random instants: nothing may be lost, doubled or changed.

The campaign has simulators, and is resumed each time its coordinator is killed. At the end, its table has to equal
that of an undisturbed campaign, apart from columns about the machine.

    python benchmarks/campaign_kills.py [--kills N] [--runs N] [--seed N]
"""

from __future__ import annotations

import argparse
import csv
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from itertools import zip_longest
from pathlib import Path
from typing import Final

from seoro.campaign.runs import OF_THE_MACHINE

SCENARIO: Final = """import osc.driving

scenario drives:
    turtlebot4: differential_drive_robot
    pace: speed
    keep(pace in [0.1mps..0.3mps])
    cover(pace, unit: mps, range: [0.1..0.3], every: 0.05)
    do turtlebot4.drive(linear: pace, duration: 0.3s)
"""
OPTIONS: Final = ("--strategy", "random", "--sim", "mujoco", "--rate", "max", "--seed", "1", "--keep", "none")
SEORO: Final = (sys.executable, "-m", "seoro", "campaign")
ROWS: Final = (0, 0, 1, 5, 20)  # new ones before a kill
LONGEST: Final = 0.5  # [s] after them
STEP: Final = 20  # kills between two lines about the progress
ROLES: Final = ("coordinator", "fork server", "worker", "simulator")


def measure_kills(kills: int, runs: int, seed: int) -> bool:
    """Kill processes of a campaign, and print what became of its runs.

    Args:
        kills: Number of kills.
        runs: Least number of runs; there are more if these end before the last kill.
        seed: Seed of the instants.

    Returns:
        Whether all runs are there once, and equal the undisturbed ones.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "drives.osc").write_text(SCENARIO)
        killed, runs = _disturb(folder, kills, runs, random.Random(seed))
        out = folder / "undisturbed"
        _run(folder, "run", "drives.osc", *OPTIONS, "--runs", str(runs), "-o", str(out)).wait()
        disturbed, undisturbed = _table(folder / "out"), _table(out)
    numbers = [int(row["run"]) for row in disturbed]
    attempts = Counter(row["attempt"] for row in disturbed)
    pairs = zip_longest(map(_lasting, disturbed), map(_lasting, undisturbed))
    different = [one or other for one, other in pairs if one != other]
    print(f"kills: {', '.join(f'{killed[role]} of a {role}' for role in ROLES)}")
    print(f"runs: {runs}, in the table {len(numbers)}, distinct {len(set(numbers))}")
    print(f"attempts: {', '.join(f'{attempts[number]} runs with {number}' for number in sorted(attempts))}")
    print(f"runs that differ from those of an undisturbed campaign: {len(different)}")
    return numbers == list(range(1, runs + 1)) and not different


def _disturb(folder: Path, kills: int, runs: int, draw: random.Random) -> tuple[Counter[str], int]:
    """Kill processes of a campaign; returns the kills by role, and the final number of runs."""
    killed: Counter[str] = Counter()
    command: tuple[str, ...] = ("run", "drives.osc", *OPTIONS)
    while killed.total() < kills:
        process = _run(folder, *command, "--runs", str(runs), *(("-o", "out") if command[0] == "run" else ()))
        while process.poll() is None and killed.total() < kills:
            wanted = _rows(folder) + draw.choice(ROWS)
            while process.poll() is None and _rows(folder) < wanted:
                time.sleep(0.02)
            time.sleep(draw.uniform(0.0, LONGEST))
            role = draw.choice(ROLES)
            victims = sorted(_processes(process.pid, role))
            if process.poll() is None and victims:
                with suppress(ProcessLookupError):
                    os.kill(draw.choice(victims), signal.SIGKILL)
                    killed[role] += 1
                    if killed.total() % STEP == 0:
                        print(f"{killed.total()} kills, {_rows(folder)} rows", flush=True)
        if killed.total() < kills and _rows(folder) >= runs:
            runs += 100  # it was over too early
        if process.poll() is None and killed.total() == kills:
            process.wait()
        command = ("resume", "out") if (folder / "out" / "campaign.json").exists() else command
    _run(folder, "resume", "out", "--runs", str(runs)).wait()
    return killed, runs


def _run(folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([*SEORO, *arguments], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def _rows(folder: Path) -> int:
    return sum(path.read_bytes().count(b"\n") for path in (folder / "out" / "runs").glob("*.jsonl"))


def _processes(coordinator: int, role: str) -> Iterator[int]:
    """Yield the processes of a campaign with a role."""
    children: dict[int, list[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            with suppress(OSError):
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                children.setdefault(parent, []).append(int(entry.name))
    if role == "coordinator":
        yield coordinator
    for child in children.get(coordinator, []):
        is_simulator = "sim_nodes" in _command(child)
        if role == ("simulator" if is_simulator else "fork server"):
            yield child
        if role == "worker" and not is_simulator:
            yield from children.get(child, [])


def _command(process: int) -> list[str]:
    try:
        return Path(f"/proc/{process}/cmdline").read_text().split("\0")
    except OSError:
        return []


def _table(folder: Path) -> list[dict[str, str]]:
    with (folder / "runs.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def _lasting(row: dict[str, str]) -> dict[str, str]:
    return {name: value for name, value in row.items() if name not in OF_THE_MACHINE}


def main() -> int:
    """Run the benchmark; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200, help="number of kills")
    parser.add_argument("--runs", type=int, default=1000, help="least number of runs")
    parser.add_argument("--seed", type=int, default=1, help="seed of the instants")
    options = parser.parse_args()
    return int(not measure_kills(options.kills, options.runs, options.seed))


if __name__ == "__main__":
    sys.exit(main())
