"""How long a scenario of three lines takes, from the command to its end, and beside it `scenario-execution`.

    python benchmarks/startup.py [--rounds N] [--peer PYTHON | --install-peer]

Each round runs Python with nothing to do, `seoro exec` and, if it is asked for, the peer, one after the other.
Times are of the wall clock and of the processor, in seconds; the medians of all rounds. The files of seoro are
compiled first, as an installer compiles those of the peer.
"""

from __future__ import annotations

import argparse
import compileall
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import peer

import seoro

HELLO = 'import osc.helpers\nscenario hello:\n    do serial:\n        log("hello")\n'
GOAL = 0.5  # of the peer's time


def measure(command: list[str]) -> tuple[float, float]:
    """Seconds of the wall clock and of the processor that a command takes."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="How long a scenario of three lines takes.")
    parser.add_argument("--rounds", type=int, default=11)
    peer.add_peer_arguments(parser)
    options = parser.parse_args()
    compileall.compile_dir(Path(seoro.__file__).parent, quiet=2)
    with tempfile.TemporaryDirectory() as folder:
        hello = Path(folder) / "hello.osc"
        hello.write_text(HELLO)
        commands = {
            "python -c pass": [sys.executable, "-c", "pass"],
            "seoro exec": [str(Path(sys.executable).with_name("seoro")), "exec", str(hello)],
        }
        python = peer.peer_of(options)
        if python is not None:
            commands["scenario_execution"] = [*peer.command(python), str(hello)]
        measured: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
        for _ in range(options.rounds):
            for name, command in commands.items():
                measured[name].append(measure(command))
    medians = {
        name: tuple(statistics.median(each) for each in zip(*rounds, strict=True))
        for name, rounds in measured.items()
    }
    print(f"{'':20} {'wall':>8} {'processor':>10}")
    for name, (wall, processor) in medians.items():
        print(f"{name:20} {wall:7.3f}s {processor:9.3f}s")
    if python is not None:
        wall, processor = (
            own / other for own, other in zip(medians["seoro exec"], medians["scenario_execution"], strict=True)
        )
        print(f"{'ratio':20} {wall:8.2f} {processor:10.2f}   goal: at most {GOAL}")


if __name__ == "__main__":
    main()
