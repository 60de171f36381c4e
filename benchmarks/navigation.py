"""Cost of navigation: simulated seconds per second of processor time.

    python benchmarks/navigation.py [ENGINE ...] [--robots N ...] [--rounds N] [--against CHECKOUT]

In the maze, in this process, without Zenoh. For each number of robots, the best of some rounds:

- bare: the engine's own step, in a loop of Python;
- at rest: the simulation of robots that stand;
- navigating: every robot drives to goals that are too far to be reached in a round.

With `--against`, the same is measured in another checkout of the sources.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

from sim_nodes.__main__ import ENGINES
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.goals import Goal
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import load_world

PLACES = tuple((x * 1.5, y * 1.5) for y in range(-1, 3) for x in range(-2, 2))
HOME = (0.0, 0.0)
DURATION = 8.0  # [s] of simulated time
NUMBERS = (1, 4, 16)


def make_simulation(engine: str, robots: int) -> Simulation:
    """Return the maze with some robots, one of them at its start."""
    text = resources.files("sim_nodes.worlds").joinpath("maze.yaml").read_text(encoding="utf-8")
    others = [place for place in PLACES if place != HOME][: robots - 1]
    for number, (x, y) in enumerate(others, 2):
        text += f"  - {{name: robot{number}, robot: turtlebot4, pose: {{x: {x}, y: {y}}}}}\n"
    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder) / "world.yaml"
        world.write_text(text, encoding="utf-8")
        return Simulation(ENGINES[engine](), load_world(str(world)), 0)


def measure_bare(simulation: Simulation) -> float:
    """Simulated seconds per second of the engine alone."""
    engine = simulation.engine
    count = round(DURATION * engine.steps_per_second)
    start = time.process_time()
    engine.step(count)
    return DURATION / (time.process_time() - start)


def measure_run(simulation: Simulation) -> float:
    """Simulated seconds per second of a simulation."""
    start, begin = time.process_time(), simulation.time
    simulation.run(begin + DURATION)
    return DURATION / (time.process_time() - start)


def send_away(simulation: Simulation) -> None:
    """Send every robot to a far goal."""
    for number, (name, robot) in enumerate(simulation.robots.items()):
        start = simulation.frames.true_pose(name)
        robot.mobile.set_initial_pose(start, simulation.tick)
        x = 4.5 if start.x < 0.0 else -4.5
        goal = Goal(f"goal{number}", (Pose2(x, -4.5 if start.y > 0.0 else 4.5, 0.0),), stop_at_each=False)
        simulation.navigate(name, goal)
    simulation.run(simulation.time + 1.0)  # loads modules, and makes the first plans


def measure(engine: str, robots: int, rounds: int) -> list[float]:
    """Return the best rates: bare, at rest, navigating."""
    best = [0.0, 0.0, 0.0]
    for _ in range(rounds):
        simulation = make_simulation(engine, robots)
        rates = [measure_run(simulation), measure_bare(simulation)]
        simulation = make_simulation(engine, robots)
        send_away(simulation)
        rest, bare, navigating = *rates, measure_run(simulation)
        best = [max(pair) for pair in zip(best, (bare, rest, navigating), strict=True)]
    return best


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the cost of navigation.")
    parser.add_argument("engines", metavar="ENGINE", nargs="*", help="mujoco, pybullet (default: those installed)")
    parser.add_argument("--robots", type=int, nargs="+", default=list(NUMBERS), metavar="N")
    parser.add_argument("--rounds", type=int, default=3, metavar="N")
    parser.add_argument("--against", type=Path, metavar="CHECKOUT")
    options = parser.parse_args()
    print(f"{'engine':10}{'robots':>7}{'bare':>9}{'at rest':>9}{'navigating':>12}")
    for engine in options.engines or [name for name in ENGINES if find_spec(name)]:
        for robots in options.robots:
            bare, rest, navigating = measure(engine, robots, options.rounds)
            print(f"{engine:10}{robots:7}{bare:9.1f}{rest:9.1f}{navigating:12.2f}", flush=True)
    if options.against is not None:
        print(f"\n{options.against}")
        again = [argument for argument in sys.argv if not argument.startswith("--against")]
        again.remove(str(options.against)) if str(options.against) in again else None
        environment = {**os.environ, "PYTHONPATH": str(options.against)}
        subprocess.run([sys.executable, *again], env=environment, check=True)


if __name__ == "__main__":
    main()
