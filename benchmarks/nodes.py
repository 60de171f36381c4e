"""Start-up and memory of simulator nodes, and worlds of many robots at rest.

    python benchmarks/nodes.py [ENGINE ...] [--rounds N] [--loads N] [--against FOLDER]

For each engine:

- start: processor time of a node process with the maze until it accepts requests, and its resident memory then;
- navigating: resident memory of a node whose robot has driven in the maze for 5 s;
- loads: resident memory of one node after a tenth of many loads of two worlds, and after all of them;
- at rest: simulated seconds per second of processor time with 16 and with 64 robots that stand;
- people: processor time of a tick of 20 ms with 20 people of the social force model who walk around a robot.

`--against` also measures the nodes of another checkout of the project with its own `.venv`, in turns with these.
Processor times grow with other load on the machine; the smallest of the rounds depends on it least.
"""

from __future__ import annotations

import argparse
import asyncio
import compileall
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

import processes

from seoro.bridges import wire
from seoro.bridges.session import open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire import Pose3D, Position3D

ROOT = Path(__file__).parents[1]
ROBOT = "turtlebot4"
WORLDS = ("rooms", "maze")
CROWDS = (16, 64)  # numbers of robots
SPACING = 2.0  # [m] between robots
PEOPLE = 20
SIMULATED = 5  # [s] at rest, and with people
TICK = 0.02  # [s]
MIB = 1024.0  # [KiB]


class Node:
    """A node process of a checkout of the project."""

    def __init__(self, root: Path, engine: str, endpoint: str) -> None:
        command = [str(root / ".venv/bin/python"), "-m", "sim_nodes", engine, "--listen", endpoint]
        self._process = subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        assert self._process.stdout is not None
        self._process.stdout.readline()  # it accepts requests

    def processor_time(self) -> float:
        """Return the processor time of the process so far [s]."""
        return processes.processor_time(self._process.pid)

    def memory(self) -> float:
        """Return the resident memory of the process [MiB]."""
        status = Path(f"/proc/{self._process.pid}/status").read_text()
        return int(status.partition("VmRSS:")[2].split()[0]) / MIB

    def stop(self) -> None:
        """Stop the process."""
        self._process.terminate()
        self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()


@asynccontextmanager
async def opened(root: Path, engine: str) -> AsyncIterator[tuple[Node, NodeAddress]]:
    """Start a node, and connect to it."""
    with tempfile.TemporaryDirectory() as folder:
        endpoint = f"unixsock-stream/{folder}/node.sock"
        node = Node(root, engine, endpoint)
        try:
            async with open_session(connect=endpoint) as session:
                yield node, NodeAddress(session, wire.NAMESPACE, engine)
        finally:
            node.stop()


async def measure_start(root: Path, engine: str) -> tuple[float, float]:
    """Return the processor time [s] and the memory [MiB] of a node that has started."""
    async with opened(root, engine) as (node, _):
        return node.processor_time(), node.memory()


async def measure_navigating(root: Path, engine: str) -> float:
    """Return the memory of a node whose robot navigates [MiB]."""
    async with opened(root, engine) as (node, address):
        start, goal = Pose3D(Position3D(0.0, 0.0)), Pose3D(Position3D(3.0, -3.0))
        await ask(address, wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=ROBOT, pose=start))
        box = resources.files("seoro").joinpath("models/example_simulation/models/box.sdf").read_text()
        await ask(
            address,
            wire.SPAWN_ENTITY,
            wire.SpawnEntity(
                name="box", uri="box.sdf", resource_string=box, initial_pose=Pose3D(Position3D(1.0, -1.0, 0.15))
            ),
        )
        drive = wire.NavigateThroughPoses(id="goal", robot=ROBOT, poses=(goal,), stop_at_each=False)
        await ask(address, wire.NAVIGATE_THROUGH_POSES, drive)
        for second in range(1, SIMULATED + 1):
            await ask(address, wire.ADVANCE, wire.Advance(until=float(second)))
        return node.memory()


async def measure_loads(root: Path, engine: str, count: int) -> tuple[float, float]:
    """Return the memory [MiB] after a tenth of the loads, and after all."""
    async with opened(root, engine) as (node, address):
        early = 0.0
        for index in range(count):
            await ask(address, wire.LOAD_WORLD, wire.LoadWorld(world=WORLDS[index % 2], seed=index))
            if index == count // 10:
                early = node.memory()
        return early, node.memory()


async def measure_rest(root: Path, engine: str, robots: int) -> float:
    """Return simulated seconds per second of processor time."""
    return SIMULATED / await measure_world(root, engine, crowd(robots))


async def measure_world(root: Path, engine: str, text: str) -> float:
    """Return the processor time that `SIMULATED` seconds of a world take [s]."""
    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder) / "crowd.yaml"
        world.write_text(text)
        async with opened(root, engine) as (node, address):
            await ask(address, wire.LOAD_WORLD, wire.LoadWorld(world=str(world)))
            before = node.processor_time()
            for second in range(1, SIMULATED + 1):  # each request has a time limit
                await ask(address, wire.ADVANCE, wire.Advance(until=float(second)))
            return node.processor_time() - before


def crowd(robots: int) -> str:
    """Return a world file of robots in rows of eight."""
    rows = (robots + 7) // 8
    lines = [f"name: crowd\nextent: [0, 0, {9 * SPACING}, {(rows + 1) * SPACING}]\nrobots:"]
    for index in range(robots):
        x, y = (index % 8 + 1) * SPACING, (index // 8 + 1) * SPACING
        lines.append(f"  - {{name: robot{index}, robot: turtlebot4, pose: {{x: {x}, y: {y}}}}}")
    return "\n".join(lines)


def hall() -> str:
    """Return a world file of a hall with people and a robot."""
    return f"""
name: hall
extent: [-10, -10, 10, 10]
robots:
  - {{name: robot, robot: turtlebot4}}
crowds:
  - {{name: people, count: {PEOPLE}, area: [-9, -9, 9, 9], wander: [-9, -9, 9, 9]}}
"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure simulator nodes.")
    parser.add_argument("engines", nargs="*", metavar="ENGINE", default=["mujoco", "pybullet"])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--loads", type=int, default=1000)
    parser.add_argument("--against", type=Path, metavar="FOLDER")
    options = parser.parse_args()
    roots = [ROOT, *([options.against.resolve()] if options.against else [])]
    for root in roots:
        for package in ("seoro", "sim_nodes"):
            compileall.compile_dir(root / package, quiet=2)
    for engine in options.engines:
        if find_spec(engine) is None:
            sys.exit(f"{engine} is not installed")
        for root, row in zip(
            roots, asyncio.run(measured(roots, engine, options.rounds, options.loads)), strict=True
        ):
            print(f"{engine:9} {'these files' if root == ROOT else root}: {row}", flush=True)


async def measured(roots: list[Path], engine: str, rounds: int, loads: int) -> list[str]:
    """Return a line of figures for each checkout."""
    starts = [[await measure_start(root, engine) for root in roots] for _ in range(rounds)]
    rows = []
    for index, root in enumerate(roots):
        time, memory = (min(values) for values in zip(*(each[index] for each in starts), strict=True))
        driving = await measure_navigating(root, engine)
        early, late = await measure_loads(root, engine, loads)
        rests = [await measure_rest(root, engine, robots) for robots in CROWDS]
        people = 1000.0 * await measure_world(root, engine, hall()) * TICK / SIMULATED
        shown = ", ".join(f"{robots} robots {rest:.1f}" for robots, rest in zip(CROWDS, rests, strict=True))
        rows.append(
            f"start {time:.2f} s, {memory:.0f} MiB; navigating {driving:.0f} MiB; "
            f"{loads} loads {early:.0f} -> {late:.0f} MiB; at rest {shown}; "
            f"{PEOPLE} people {people:.2f} ms"
        )
    return rows


if __name__ == "__main__":
    main()
