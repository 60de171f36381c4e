"""Cost of poses and scenes in traces, and of recordings.

    python benchmarks/recordings.py [--sim NAME] [--robots N ...] [--rounds N]

Runs `seoro exec` with and without poses in turns, with one robot in the scenario of the obstacle and with more in
the maze, and prints:

- processor time of all processes of a run, without what a run of 0 s takes: the least of some rounds;
- size of the records of poses and scenes per robot and simulated minute;
- processor time in which the trace becomes a recording.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from importlib import resources
from pathlib import Path

from seoro.traces.foxglove import is_foxglove_installed
from seoro.traces.reader import read_trace, valid_records

OBSTACLE = Path(__file__).resolve().parent.parent / "scenarios" / "navigation" / "obstacle.osc"
PLACES = [(x * 1.5, y * 1.5) for y in range(-1, 3) for x in range(-2, 2)]
HOME = (0.0, 0.0)
DURATION = 8.0  # [s] of simulated time with many robots
KINDS = ("poses", "scene", "entity")


def write_crowd(folder: Path, robots: int, duration: float) -> list[str]:
    """Write a scenario and a world in which robots navigate; returns the arguments of the command."""
    world = resources.files("sim_nodes.worlds").joinpath("maze.yaml").read_text(encoding="utf-8")
    places = {"turtlebot4": HOME}
    for number, (x, y) in enumerate([place for place in PLACES if place != HOME][: robots - 1], 2):
        places[f"robot{number}"] = (x, y)
        world += f"  - {{name: robot{number}, robot: turtlebot4, pose: {{x: {x}, y: {y}}}}}\n"
    (folder / "crowd.yaml").write_text(world, encoding="utf-8")
    lines = ["import osc.ros", "import osc.helpers", "", "scenario crowd:"]
    lines += [f"    {name}: differential_drive_robot" for name in places]
    lines += ["    do one_of:", f"        wait elapsed({duration:g}s)", "        parallel:"]
    for name, (x, y) in places.items():
        goal = (4.5 if x < 0.0 else -4.5, -4.5 if y > 0.0 else 4.5)
        lines += [
            "            serial:",
            f"                {name}.init_nav2(pose_3d(position_3d(x: {x}m, y: {y}m)))",
            f"                {name}.nav_to_pose(pose_3d(position_3d(x: {goal[0]}m, y: {goal[1]}m)))",
        ]
    (folder / "crowd.osc").write_text("\n".join([*lines, ""]), encoding="utf-8")
    return [str(folder / "crowd.osc"), "--world", str(folder / "crowd.yaml")]


def run(arguments: list[str], folder: Path, simulator: str, rate: float) -> float:
    """Run a scenario; returns the processor time of its processes [s]."""
    before = _children()
    options = ["--sim", simulator, "--rate", "max", "--seed", "1", "--poses", f"{rate:g}"]
    command = [sys.executable, "-m", "seoro", "exec", *arguments, *options]
    command += ["--trace", str(folder / "trace.jsonl")]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    return _children() - before


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def sizes(trace: Path) -> tuple[int, float]:
    """Return the size of the records of poses and scenes [bytes], and the duration of the run [s]."""
    size, duration = 0, 0.0
    for line in trace.read_bytes().splitlines():
        record = json.loads(line)
        size += len(line) + 1 if record["kind"] in KINDS else 0
        duration = record["t"]
    return size, duration


def convert(trace: Path) -> float:
    """Return the processor time in which a trace becomes a recording [s]."""
    from seoro.traces.foxglove.recording import write_recording  # noqa: PLC0415 - an extra

    start = time.process_time()
    with trace.open("rb") as file:
        write_recording(valid_records(read_trace(file), []), trace.with_name("recording.mcap"))
    return time.process_time() - start


def measure(simulator: str, robots: int, rounds: int) -> None:
    """Measure and print a line."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        start = min(run(write_crowd(folder, robots, 0.02), folder, simulator, 0.0) for _ in range(rounds))
        arguments = [str(OBSTACLE)] if robots == 1 else write_crowd(folder, robots, DURATION)
        least = {0.0: float("inf"), 10.0: float("inf")}
        for _ in range(rounds):
            for rate, best in tuple(least.items()):
                least[rate] = min(best, run(arguments, folder, simulator, rate) - start)
        size, duration = sizes(folder / "trace.jsonl")
        seconds = convert(folder / "trace.jsonl") if is_foxglove_installed() else float("nan")
    more = 100.0 * (least[10.0] / least[0.0] - 1.0)
    per_minute = size / 1e6 / robots / duration * 60.0
    print(
        f"{robots:6}{duration:9.1f} s{least[0.0]:10.2f} s{least[10.0]:10.2f} s{more:8.1f} %{per_minute:9.3f} MB"
        f"{1000 * seconds:10.0f} ms",
        flush=True,
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the cost of poses in traces, and of recordings.")
    parser.add_argument("--sim", default="mujoco", metavar="NAME")
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 16], metavar="N")
    parser.add_argument("--rounds", type=int, default=3, metavar="N")
    options = parser.parse_args()
    print("robots simulated  without poses  with poses  more  per robot and minute  recording")
    for robots in options.robots:
        measure(options.sim, robots, options.rounds)


if __name__ == "__main__":
    main()
