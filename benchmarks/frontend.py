"""Time of the front end for files of 10 to 10,000 statements, compared with `scenario-execution`.

    python benchmarks/frontend.py [--rounds N] [--peer PYTHON | --install-peer]

Times are of the processor, in seconds, for one process on one core; each is the minimum of all rounds, because
other load only adds to it. `--peer` names the interpreter of an environment with `scenario-execution`;
`--install-peer` makes one in the cache folder from PyPI. Then both front ends read the same files in turns,
each time in a new process: parsing, building and resolving the model there; loading, checking and lowering
here.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from peer import add_peer_arguments, peer_of

from seoro.lang import frontend

SIZES = (10, 30, 100, 300, 1000, 3000, 10_000)  # statements
PEER_SIZES = (100, 1000, 3000)
STEPS = ("load", "check", "lower")

MIXED = """
type quantity_{n} is SI(kg: 1, m: 2, s: -3)
unit big_{n} of quantity_{n} is SI(kg: 1, m: 2, s: -3, factor: 1000.0)
enum colour_{n}: [red_{n}, green_{n} = 4, blue_{n}]
struct part_{n}:
    size: length = {n}.5m
    count: int = 3 + {n} * 2
    shade: colour_{n} = green_{n}
    names: list of string = ["a", "b", "part {n}"]
    def area(scale: float = 2.0) -> length is expression size * scale + 1m
    def is_big() -> bool is expression size > 10m and (count != 7 or not (shade == red_{n}))
actor machine_{n}:
    load: quantity_{n} = 2big_{n}
    first: part_{n} = part_{n}(size: 2m, count: {n} + 1)
    limit: speed = 30kph - 2mps
action machine_{n}.work:
    target: length
    patience: time = 20s + 500ms
scenario task_{n}:
    worker: machine_{n}
    distance: length = (12m + 30cm) / 2 - {n}m * 0.5
    event done(amount: length)
    do serial:
        wait elapsed(1s + 200ms)
        move: worker.work(target: distance + 2m, patience: 3min)
        parallel:
            worker.work(worker.first.size)
            one_of:
                wait @move.end
                wait elapsed(500ms)
        emit done(distance * 2.0)
"""

# Text for both front ends: without operators, methods, own units, or events with arguments.
COMMON = """
enum colour_{n}: [red_{n}, green_{n}, blue_{n}]
struct part_{n}:
    size: length = {n}.5m
    count: int = 3
    name: string = 'part {n}'
    is_new: bool = true
actor machine_{n}:
    first: part_{n}
    limit: speed = 30kph
    load: float = 2.5
action machine_{n}.work:
    target: length
    patience: time = 20s
scenario task_{n}:
    worker: machine_{n}
    distance: length = 12m
    times: int = 4
    event done
    do serial:
        log('one')
        wait elapsed(1s)
        parallel:
            serial:
                log('two')
                wait elapsed(500ms)
            waiting: serial:
                wait elapsed(2s)
                log('three')
        one_of:
            wait elapsed(3s)
            wait elapsed(4s)
        emit done
"""

SHORT = """
import osc.ros
scenario short:
    robot: differential_drive_robot
    goal: pose_3d = pose_3d(position_3d(x: 3.0m, y: -3.0m))
    limit: time = 60s
    do parallel:
        serial:
            robot.init_nav2(pose_3d(position_3d(x: 0.0m, y: 0.0m)))
            robot.nav_to_pose(goal)
            robot.nav_to_pose(pose_3d(position_3d(x: 1.0m)))
            wait elapsed(1s)
            one_of:
                robot.nav_to_pose(goal)
                wait elapsed(10s)
            emit end
        time_out: serial:
            wait elapsed(limit)
            emit fail
"""  # twenty lines


def generate(template: str, statements: int, *imports: str) -> str:
    """Return a file of about as many statements, one per line."""
    lines = [f"import {module}" for module in imports]
    number = 0
    while len(lines) < statements:
        number += 1
        lines += template.format(n=number).strip().splitlines()
    if number == 1 and statements < len(lines):  # a short file: declarations that stand by themselves
        lines = lines[: max(statements, len(imports) + 4)]
    return "\n".join([*lines, "scenario main:", "    do serial:", "        wait elapsed(1s)", ""])


def measure(path: Path) -> list[float]:
    """Return the seconds to load, check and lower a file."""
    times = [time.process_time()]
    sources = frontend.load(path)
    times.append(time.process_time())
    checked = frontend.check(sources)
    times.append(time.process_time())
    if checked.diagnostics:
        raise SystemExit(f"{path}: {checked.diagnostics[0].message}")
    frontend.lower(checked, "main" if "main" in checked.scenarios else checked.scenarios[0])
    times.append(time.process_time())
    return [after - before for before, after in pairwise(times)]


def least(rounds: int, run: Callable[[], list[float]]) -> list[float]:
    """Return the minimum time of each step."""
    return [min(each) for each in zip(*(run() for _ in range(rounds)), strict=True)]


def report_growth(folder: Path, rounds: int) -> None:
    """Print how time grows with the number of statements."""
    measured: list[tuple[int, float]] = []
    print(f"{'statements':>10} {'load':>8} {'check':>8} {'lower':>8} {'together':>9}  per statement")
    for size in SIZES:
        path = folder / f"mixed_{size}.osc"
        path.write_text(generate(MIXED, size, "osc.types"), encoding="utf-8")
        steps = least(rounds, lambda path=path: measure(path))  # type: ignore[misc]
        total = sum(steps)
        measured.append((size, total))
        shown = " ".join(f"{step:8.4f}" for step in steps)
        print(f"{size:>10} {shown} {total:9.4f}  {total / size * 1e6:.0f} us")
    large = [(size, total) for size, total in measured if size >= 300]
    print(
        f"from {large[0][0]} statements on, time grows with their number to the power of {exponent(large):.2f}\n"
    )


def exponent(points: list[tuple[int, float]]) -> float:
    """Return the slope of a line through the logarithms: 1 is linear, 2 is quadratic."""
    xs = [math.log(size) for size, _ in points]
    ys = [math.log(total) for _, total in points]
    x, y = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((a - x) * (b - y) for a, b in zip(xs, ys, strict=True)) / sum((a - x) ** 2 for a in xs)


def report_short(folder: Path, rounds: int) -> None:
    """Print the time of a scenario of twenty lines that imports the largest library."""
    path = folder / "short.osc"
    path.write_text(SHORT, encoding="utf-8")
    steps = least(rounds, lambda: own_process(path))
    shown = ", ".join(f"{name} {step * 1000:.1f} ms" for name, step in zip(STEPS, steps, strict=True))
    print(f"twenty lines that import osc.ros, after start-up: {sum(steps) * 1000:.1f} ms ({shown})\n")


def own_process(path: Path) -> list[float]:
    """Return the seconds of the steps in a new process."""
    return run_process([sys.executable, __file__, "--once", str(path)])


def run_process(command: list[str]) -> list[float]:
    """Run a process and return the numbers that it prints."""
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=600)
    return [float(word) for word in done.stdout.splitlines()[-1].split()]


def report_peer(folder: Path, rounds: int, python: str) -> None:
    """Print the times of both front ends for the same files."""
    script = str(Path(__file__).with_name("frontend_peer.py"))
    print(f"{'statements':>10} {'peer':>8} {'here':>8}  times faster")
    for size in PEER_SIZES:
        path = folder / f"common_{size}.osc"
        path.write_text(generate(COMMON, size, "osc.types", "osc.helpers"), encoding="utf-8")
        theirs: list[float] = []
        own: list[float] = []
        for _ in range(rounds):
            theirs.append(sum(run_process([python, script, str(path)])))
            own.append(sum(own_process(path)))
        print(f"{size:>10} {min(theirs):8.3f} {min(own):8.3f}  {min(theirs) / min(own):.1f}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the time of the front end.")
    parser.add_argument("--rounds", type=int, default=5)
    add_peer_arguments(parser)
    parser.add_argument("--once", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    if arguments.once:
        print(*measure(arguments.once))
        return
    print(json.dumps({"python": sys.version.split()[0], "platform": sys.platform}))
    with tempfile.TemporaryDirectory() as name:
        report_growth(Path(name), arguments.rounds)
        report_short(Path(name), arguments.rounds)
        python = peer_of(arguments)
        if python:
            report_peer(Path(name), arguments.rounds, python)


if __name__ == "__main__":
    main()
