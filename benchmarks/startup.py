"""Time of a scenario of three lines from the command to its end, compared with `scenario-execution`.

    python benchmarks/startup.py [--rounds N] [--peer PYTHON | --install-peer]

Each round runs an empty Python program, `seoro --help`, `seoro exec` of an edited file, `seoro exec` of an
unchanged file with a cached plan, and, if requested, the peer.
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
from collections.abc import Mapping
from pathlib import Path

import peer

import seoro

HELLO = 'import osc.helpers\nscenario hello:\n    do serial:\n        log("hello")\n'
GOAL = 0.5  # of the peer's time


def measure(
    command: list[str], cwd: str | None = None, env: Mapping[str, str] | None = None
) -> tuple[float, float]:
    """Seconds of the wall clock and of the processor that a command takes, in a folder and an environment."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, cwd=cwd, env=env)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the time of a scenario of three lines.")
    parser.add_argument("--rounds", type=int, default=11)
    peer.add_peer_arguments(parser)
    options = parser.parse_args()
    compileall.compile_dir(Path(seoro.__file__).parent, quiet=2)
    with tempfile.TemporaryDirectory() as folder:
        hello = Path(folder) / "hello.osc"
        hello.write_text(HELLO)
        edited = hello.with_name("edited.osc")
        own = str(Path(sys.executable).with_name("seoro"))
        commands = {
            "python -c pass": [sys.executable, "-c", "pass"],
            "seoro --help": [own, "--help"],
            "seoro exec, edited": [own, "exec", str(edited)],
            "seoro exec": [own, "exec", str(hello)],
        }
        python = peer.peer_of(options)
        if python is not None:
            commands["scenario_execution"] = [*peer.command(python), str(hello)]
        measured: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
        for number in range(options.rounds):
            edited.write_text(f"{HELLO}# {number}\n")
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
