"""Ends, durations and distances of the same scenarios in all engines.

    python benchmarks/engines.py [--seeds N] [FILE ...]

Each run is a process of its own, as a user starts it. It prints the table of `docs/reference/scenarios.md`:
medians over the seeds, and by how much the second engine's differ from the first's.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from seoro.bridges.launch import SIMULATORS
from seoro.embed.directives import Directives, read_directives
from seoro.lang.source import SourceFile

PROJECT = Path(__file__).resolve().parent.parent
FOLDERS = ("navigation", "manipulation", "experiments", "catalogue")
EXPECTED = {"passed": 0, "failed": 1}  # exit statuses
LIMIT = 300  # [s] of wall time for a run
STANDING = 0.05  # [m], [s]; less than this is nothing to compare


@dataclass(frozen=True)
class Outcome:
    """Results of a scenario in an engine.

    Args:
        ended: Status, or the number of unexpected ends.
        duration: Median of simulated time [s].
        path: Median of what all of its robots drove [m].
        contacts: Number of contacts of robots, in all runs.
    """

    ended: str
    duration: float
    path: float
    contacts: int


def directives_of(file: Path) -> Directives:
    """Read the directives at the top of a file, or above its only scenario."""
    source = SourceFile(file.name, file.read_text(), file)
    lines = [number for number in range(1, source.line_count + 1) if source.line(number).startswith("scenario ")]
    found = read_directives(source, frozenset(lines))
    return found.scenarios.get(lines[-1], found.common)


def measure(file: Path, simulator: str, seeds: int, folder: Path) -> Outcome:
    """Run a scenario with several seeds."""
    directives = directives_of(file)
    world = directives.world or "maze"
    durations, paths, contacts, differently = [], [], 0, 0
    for seed in range(seeds):
        results = folder / f"{file.stem}-{simulator}-{seed}"
        command = [sys.executable, "-m", "seoro", "exec", str(file), "--sim", simulator, "--world", world]
        finished = subprocess.run(
            [*command, "--rate", "max", "--seed", str(seed), "-o", str(results)],
            check=False,
            capture_output=True,
            timeout=LIMIT,
            cwd=PROJECT,
        )
        differently += finished.returncode != EXPECTED[directives.expect]
        end = json.loads((results / "trace.jsonl").read_text().splitlines()[-1])
        robots = json.loads((results / "measurements.json").read_text())["robots"].values()
        durations.append(end["duration"])
        paths.append(sum(robot["path_length"] for robot in robots))
        contacts += sum(robot["contacts"] for robot in robots)
    ended = f"**{differently} of {seeds} not {directives.expect}**" if differently else directives.expect
    return Outcome(ended, statistics.median(durations), statistics.median(paths), contacts)


def row(name: str, outcomes: Sequence[Outcome]) -> str:
    """A row of the table."""
    ends = " / ".join(dict.fromkeys(outcome.ended for outcome in outcomes))
    durations = [outcome.duration for outcome in outcomes]
    paths = [outcome.path for outcome in outcomes]
    cells = [
        f"`{name}`",
        ends,
        *(f"{duration:.2f}" for duration in durations),
        difference(durations),
        *(f"{path:.2f}" if path > STANDING else "" for path in paths),
        difference(paths),
        "/".join(str(outcome.contacts) for outcome in outcomes),
    ]
    return f"| {' | '.join(cells)} |"


def difference(values: Sequence[float]) -> str:
    """Return the relative difference of the second of two values."""
    first, *_, last = values
    return "" if first < STANDING else f"{100.0 * (last - first) / first:+.1f} %"


def main() -> int:
    """Print the table; exit with 1 if a scenario does not end as it has to in all engines."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument(
        "files",
        nargs="*",
        type=Path,
        metavar="FILE",
        help="scenarios (default: those of the experiments and the catalogue)",
    )
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="0 to N-1 (default: 1)")
    options = parser.parse_args()
    files = options.files or [
        file for name in FOLDERS for file in sorted((PROJECT / "scenarios" / name).glob("*.osc"))
    ]

    units = [*(f"{name} [s]" for name in SIMULATORS), "", *(f"{name} [m]" for name in SIMULATORS), ""]
    print(f"| scenario | ends | {' | '.join(units)} | contacts |")
    print(f"|---|---|{'---|' * len(units)}---|")
    good = True
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            outcomes = [measure(file.resolve(), name, options.seeds, Path(folder)) for name in SIMULATORS]
            good = good and not any(outcome.ended.startswith("*") for outcome in outcomes)
            print(row(file.stem, outcomes), flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
