"""Verdicts, durations and contacts of the obstacle scenario with seeds 0 to 19.

    python benchmarks/obstacle.py [--sim NAME] [--seeds N] [--repeat]

Each run is a process of its own, as a user starts it. With `--repeat`, each seed is run twice,
and the traces are compared.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

SCENARIO = Path(__file__).resolve().parent.parent / "scenarios" / "navigation" / "obstacle.osc"


def run(simulator: str, seed: int, folder: Path) -> tuple[int, float, list[dict[str, Any]]]:
    """Return exit status, wall time [s] and trace of one run."""
    trace = folder / f"{seed}.jsonl"
    command = [sys.executable, "-m", "seoro", "exec", str(SCENARIO), "--sim", simulator, "--rate", "max"]
    start = time.monotonic()
    finished = subprocess.run(
        [*command, "--seed", str(seed), "--trace", str(trace)], check=False, capture_output=True, timeout=120
    )
    wall = time.monotonic() - start
    records = [json.loads(line) for line in trace.read_text().splitlines()]
    return finished.returncode, wall, records


def without_wall(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a trace without wall clock times."""
    return [{key: value for key, value in record.items() if key != "wall"} for record in records]


def main() -> int:
    """Run all seeds; exit with 1 if one does not pass, touches something, or is not the same again."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument("--sim", default="mujoco", metavar="NAME", help="mujoco or pybullet (default: mujoco)")
    parser.add_argument("--seeds", type=int, default=20, metavar="N")
    parser.add_argument("--repeat", action="store_true", help="run each seed twice and compare the traces")
    options = parser.parse_args()

    good, simulated, walls = True, [], []
    print("seed  status  simulated  wall    contacts")
    with tempfile.TemporaryDirectory() as name:
        for seed in range(options.seeds):
            status, wall, records = run(options.sim, seed, Path(name))
            contacts = [r["arguments"] for r in records if r["kind"] == "event" and r["name"] == "contact"]
            duration = records[-1]["duration"]
            same = not options.repeat or without_wall(run(options.sim, seed, Path(name))[2]) == without_wall(
                records
            )
            good = good and status == 0 and not contacts and same
            simulated.append(duration)
            walls.append(wall)
            remark = "" if same else "  the second trace differs"
            print(f"{seed:4}  {status:6}  {duration:7.2f} s  {wall:4.2f} s  {contacts or 'none'}{remark}")
    print(f"simulated: median {statistics.median(simulated):.1f} s, at most {max(simulated):.1f} s")
    print(f"wall:      median {statistics.median(walls):.2f} s, at most {max(walls):.2f} s, start to exit")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
