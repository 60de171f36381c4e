"""Cost of snapshots, and time saved by continuing from one.

    python benchmarks/snapshots.py [ENGINE ...] [--runs N] [--hour]

A robot drives through the world `maze`. Three quarters of the way there everything is saved. Then the rest is done
once for each of some seeds, from there and from the start. The node is a process of its own.

With `--hour`, a robot is driven in curves through the world `empty` for an hour of simulated time instead, and
saved and restored once.
"""

from __future__ import annotations

import argparse
import asyncio
import statistics
import time
from collections.abc import Awaitable, Callable
from functools import partial
from importlib.util import find_spec
from random import Random

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, start_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.node import SimulatorNode
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import Report
from sim_nodes.__main__ import ENGINES

ROBOT = "turtlebot4"
GOAL = Pose3D(Position3D(3.0, -3.0))
SAVED_AT = 21.0  # [s] of about 28
HOUR = 3600.0  # [s]
CURVE = 5.0  # [s]
END = 32.0  # [s] by which the robot has arrived, and stands


async def drive_from_the_start(node: SimulatorNode, seed: int, until: float) -> None:
    """Load the world, and drive."""
    await node.load_world("maze", seed)
    await node.set_initial_pose(ROBOT, Pose3D())
    await node.navigate(ROBOT, [GOAL], stop_at_each=False, report=_ignore)
    await _advance(node, until)


async def go_on_from(node: SimulatorNode, snapshot: wire.Snapshot, seed: int) -> None:
    """Begin at a snapshot, and drive on."""
    await node.begin_from(snapshot, seed)
    await node.navigate(ROBOT, [GOAL], stop_at_each=False, report=_ignore)
    await _advance(node, END - SAVED_AT)


async def _advance(node: SimulatorNode, until: float) -> None:
    now = 0.0
    while now < until:
        now = await node.advance(until)


async def _timed(act: Callable[[], Awaitable[object]]) -> float:
    start = time.perf_counter()
    await act()
    return time.perf_counter() - start


async def measure(engine: str, runs: int) -> None:
    """Measure one engine, and print the results."""
    async with start_simulator(engine, SimulatorOptions("maze", 0, ModelPath())) as node:
        await drive_from_the_start(node, 0, SAVED_AT)
        saving = [await _timed(lambda: node.ask(wire.SAVE_STATE, wire.Empty())) for _ in range(10)]
        snapshot = await node.ask(wire.SAVE_STATE, wire.Empty())
        restoring = [await _timed(lambda: node.begin_from(snapshot, 0)) for _ in range(5)]
        whole, rest = [], []
        for seed in range(runs):  # by turns, so that a busy machine slows both
            whole.append(await _timed(partial(drive_from_the_start, node, seed, END)))
            rest.append(await _timed(partial(go_on_from, node, snapshot, seed)))
    print(f"{engine}: {len(wire.encode(snapshot)) / 1000:.0f} kB")
    print(f"  saved in {1000 * statistics.median(saving):.0f} ms, restored in", end=" ")
    print(f"{1000 * statistics.median(restoring):.0f} ms")
    print(f"  a whole run of {END:g} s: {statistics.median(whole):.2f} s, the last", end=" ")
    print(f"{END - SAVED_AT:g} s from a snapshot: {statistics.median(rest):.2f} s (medians of {runs} seeds)")


async def measure_hour(engine: str) -> None:
    """Measure one engine after an hour, and print the results."""
    async with start_simulator(engine, SimulatorOptions("empty", 0, ModelPath())) as node:
        simulated = await _timed(partial(_drive_in_curves, node, HOUR))
        snapshot = await node.ask(wire.SAVE_STATE, wire.Empty())
        saving = await _timed(lambda: node.ask(wire.SAVE_STATE, wire.Empty()))
        restoring = await _timed(lambda: node.begin_from(snapshot, 0))
    print(
        f"{engine}: an hour, simulated in {simulated:.0f} s: {len(wire.encode(snapshot)) / 1000:.0f} kB,", end=" "
    )
    print(f"saved in {1000 * saving:.0f} ms, restored in {restoring:.1f} s")


async def _drive_in_curves(node: SimulatorNode, until: float) -> None:
    now, random = 0.0, Random(0)
    while now < until:
        turn = random.choice((-1, 1)) * random.uniform(0.8, 1.4)
        await node.drive(ROBOT, 0.2, turn, CURVE, _ignore)
        end = now + CURVE + 0.1
        while now < end:
            now = await node.advance(end)


def _ignore(report: Report) -> None:
    """Ignore the result of the goal."""


def main() -> None:
    """Measure the engines that are installed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("engines", nargs="*", metavar="ENGINE", default=[*ENGINES])
    parser.add_argument("--runs", type=int, default=8, metavar="N", help="seeds (default: %(default)s)")
    parser.add_argument("--hour", action="store_true", help="measure what an hour of driving costs")
    options = parser.parse_args()
    for engine in options.engines:
        if find_spec(engine) is not None:
            asyncio.run(measure_hour(engine) if options.hour else measure(engine, options.runs))


if __name__ == "__main__":
    main()
