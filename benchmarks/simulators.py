"""How fast simulators are: an engine alone, with its lidar, and as a node that navigates.

    python benchmarks/simulators.py [ENGINE ...] [--rounds N]

All in the world `maze` with a TurtleBot 4 that drives. The node is a process of its own and is granted 50 ms of
simulated time at once, as a run at `--rate 1` does it. Figures are the medians of all rounds.
"""

from __future__ import annotations

import argparse
import asyncio
import statistics
import time
from collections.abc import Callable
from importlib.util import find_spec

from seoro.bridges.launch import SimulatorOptions, start_simulator
from seoro.bridges.models import ModelPath
from seoro.runtime.contracts import Pose3D, Position3D, Report
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.rays import DIRECTIONS, LIMIT
from sim_nodes.physics import Engine
from sim_nodes.worlds.loader import load_world

ROBOT = "turtlebot4"
STEPS = 5000
SCANS = 200
GRANT = 0.05  # [s]
DRIVE = 20.0  # [s] of simulated time; the way to the goal takes longer
GOAL = Pose3D(Position3D(3.0, -3.0))


def rate(act: Callable[[], object], count: int) -> float:
    """Calls per second."""
    start = time.perf_counter()
    for _ in range(count):
        act()
    return count / (time.perf_counter() - start)


def measure_engine(name: str) -> tuple[float, float, float]:
    """Steps per second, the same with looking for contacts, and scans per second."""
    engine: Engine = ENGINES[name]()
    engine.build(load_world("maze").scene)
    engine.command_wheels(ROBOT, 3.0, 6.0)  # around in a circle, away from walls

    def observed() -> None:
        engine.step()
        engine.touching()

    bare, seen = rate(engine.step, STEPS), rate(observed, STEPS)
    return bare, seen, rate(lambda: engine.cast_rays(ROBOT, DIRECTIONS, LIMIT), SCANS)


async def measure_node(name: str) -> float:
    """Simulated seconds per second of a node whose robot navigates."""
    async with start_simulator(name, SimulatorOptions("maze", 0, ModelPath())) as node:
        await node.set_initial_pose(ROBOT, Pose3D())
        await node.navigate(ROBOT, [GOAL], stop_at_each=False, report=_ignore)
        start, simulated = time.perf_counter(), 0.0
        while simulated < DRIVE:
            simulated = await node.advance(simulated + GRANT)
        return simulated / (time.perf_counter() - start)


def _ignore(_report: Report) -> None:
    """The drive is not driven to its end."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="How fast simulators are.")
    parser.add_argument("engines", metavar="ENGINE", nargs="*", help="mujoco, pybullet (default: those installed)")
    parser.add_argument("--rounds", type=int, default=5, metavar="N")
    options = parser.parse_args()
    print("engine      step [us]  with contacts [us]  scan [ms]  engine alone  node that navigates")
    for name in options.engines or [name for name in ENGINES if find_spec(name)]:
        rounds = [(*measure_engine(name), asyncio.run(measure_node(name))) for _ in range(options.rounds)]
        bare, seen, scans, node = (statistics.median(values) for values in zip(*rounds, strict=True))
        alone = bare / ENGINES[name]().steps_per_second
        times = f"{1e6 / bare:9.1f}  {1e6 / seen:18.1f}  {1e3 / scans:9.2f}"
        print(f"{name:10}  {times}  {alone:8.0f} x RT  {node:15.1f} x RT")
    print("x RT: simulated seconds per second")


if __name__ == "__main__":
    main()
