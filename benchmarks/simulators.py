"""Speed of simulators, compared with their engines alone.

    python benchmarks/simulators.py [ENGINE ...] [--rounds N] [--scenes SCENE ...]

For each engine and scene, in turns in one run:

- bare: the engine's own step, in a loop of Python, in a process that has loaded the same scene;
- free: a simulator node that plays as fast as possible, a process of its own; robots stand and sense nothing;
- lock-step: the same node, granted 20 ms at a time over Zenoh;
- asked: the same, and each time it is asked for the robot's pose;
- long grants: the same, granted 1 s at a time.

Then a node whose robot navigates in the maze, in grants of 50 ms, and a scan of its lidar. Figures are medians of
all rounds, in simulated seconds per second. Shares are medians of the ratios to the bare engine, measured right
before and after, so that other load affects both.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import statistics
import tempfile
import time
from collections.abc import Awaitable, Callable
from functools import partial
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, start_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.node import SimulatorNode
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import Report
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.sensing import DIRECTIONS, LIMIT
from sim_nodes.physics import Engine
from sim_nodes.worlds.loader import load_world

ROBOT = "turtlebot4"
ROUND = 0.5  # [s] of the machine's clock for each measurement of a round
REQUEST = 1e-4  # [s]; more than a grant takes whose time was simulated already, and less than a request
SCANS = 100
DRIVE = 10.0  # [s] of simulated time; the way to the goal takes longer
GOAL = Pose3D(Position3D(3.0, -3.0))
PLACES = (
    (-1.5, 0.0),
    (1.5, 0.0),
    (-3.0, -3.0),
    (3.0, 3.0),
    (0.0, 1.5),
    (-4.5, 0.0),
    (1.5, -3.0),
    (-1.5, 3.0),
    (3.0, -3.0),
)


def scenes() -> dict[str, str]:
    """Return world files by scene."""
    maze, cell = (
        resources.files("sim_nodes.worlds").joinpath(f"{name}.yaml").read_text(encoding="utf-8")
        for name in ("maze", "arm_cell")
    )
    more = "".join(
        f"  - {{name: robot{index}, robot: turtlebot4, pose: {{x: {x}, y: {y}}}}}\n"
        for index, (x, y) in enumerate(PLACES, 2)
    )
    return {"maze, 1 robot": maze, "maze, 10 robots": f"{maze}{more}", "arm cell": cell}


def bare_step(name: str, world: Path) -> tuple[Any, Callable[[], object]]:
    """An engine with a scene, and its own step, past all that is ours."""
    engine: Any = ENGINES[name]()
    engine.build(load_world(str(world)).scene)
    if name == "mujoco":
        import mujoco  # noqa: PLC0415

        return engine, partial(mujoco.mj_step, engine._model, engine._data)
    import pybullet  # noqa: PLC0415

    return engine, partial(pybullet.stepSimulation, engine._client)


def measure_bare(step: Callable[[], object], steps_per_second: int) -> float:
    """Simulated seconds per second."""
    start, steps = time.perf_counter(), 0
    while (passed := time.perf_counter() - start) < ROUND:
        for _ in range(200):
            step()
        steps += 200
    return steps / steps_per_second / passed


async def _nothing() -> None:
    """Send no request."""


async def measure_free(node: SimulatorNode) -> float:
    """Simulated seconds per second of a node that plays."""
    await node.ask(
        wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=wire.SimulationState.PLAYING, rate=math.inf)
    )
    start, before = time.perf_counter(), await _time_of(node)
    await asyncio.sleep(ROUND)
    after = await _time_of(node)
    passed = time.perf_counter() - start
    await node.ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=wire.SimulationState.PAUSED))
    return (after - before) / passed


async def _time_of(node: SimulatorNode) -> float:
    return (await node.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())).time


async def measure_grants(
    node: SimulatorNode, grant: float, ask: Callable[[], Awaitable[object]] = _nothing
) -> float:
    """Simulated seconds per second of a node in lock-step that is asked for something at each grant.

    Up to a grant for which the node was asked, so that nothing has been simulated that was not granted yet.
    """
    begin = now = await _time_of(node)
    start, taken = time.perf_counter(), 0.0
    while (since := time.perf_counter()) - start < 4 * ROUND or taken < REQUEST:
        reached, passed = now, since - start
        await ask()
        now = await node.advance(now + grant)
        taken = time.perf_counter() - since
    return (reached - begin) / passed


async def measure_scene(name: str, world: Path, rounds: int) -> list[list[tuple[float, float]]]:
    """Rates of each round: of the bare engine, free, in lock-step, with questions, and in long grants.

    Beside each is the rate of the bare engine around it: the mean of that before and that after.
    """
    engine, step = bare_step(name, world)
    measured: list[list[tuple[float, float]]] = []
    async with start_simulator(name, SimulatorOptions(str(world), 0, ModelPath())) as node:
        pose = partial(node.relative_pose, node.features.robots[0].frames[0], "map", 0.0)
        kinds = (
            partial(measure_free, node),
            partial(measure_grants, node, 0.02),
            partial(measure_grants, node, 0.02, pose),
            partial(measure_grants, node, 1.0),
        )
        for _ in range(rounds):
            before = measure_bare(step, engine.steps_per_second)
            found = [(before, before)]
            for measure in kinds:
                rate = await measure()
                after = measure_bare(step, engine.steps_per_second)
                found.append((rate, (before + after) / 2))
                before = after
            measured.append(found)
    return measured


async def measure_navigation(name: str) -> float:
    """Simulated seconds per second of a node whose robot navigates."""
    async with start_simulator(name, SimulatorOptions("maze", 0, ModelPath())) as node:
        await node.set_initial_pose(ROBOT, Pose3D())
        await node.navigate(ROBOT, [GOAL], stop_at_each=False, report=_ignore)
        start, simulated = time.perf_counter(), 0.0
        while simulated < DRIVE:
            simulated = await node.advance(simulated + 0.05)
        return simulated / (time.perf_counter() - start)


def measure_scan(name: str) -> float:
    """Milliseconds that a scan takes."""
    engine: Engine = ENGINES[name]()
    engine.build(load_world("maze").scene)
    start = time.perf_counter()
    for _ in range(SCANS):
        engine.cast_rays(ROBOT, "rplidar_link", DIRECTIONS, LIMIT)
    return 1e3 * (time.perf_counter() - start) / SCANS


def _ignore(_report: Report) -> None:
    """Ignore the result: the drive does not end."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure the speed of simulators.")
    parser.add_argument("engines", metavar="ENGINE", nargs="*", help="mujoco, pybullet (default: those installed)")
    parser.add_argument("--rounds", type=int, default=9, metavar="N")
    parser.add_argument("--scenes", metavar="SCENE", nargs="+", choices=scenes(), default=list(scenes()))
    options = parser.parse_args()
    print("simulated seconds per second, and as a share of the bare engine")
    print(f"{'engine':10}{'scene':17}{'bare':>7}{'free':>14}{'lock-step':>14}{'asked':>14}{'long grants':>14}")
    with tempfile.TemporaryDirectory() as folder:
        for name in options.engines or [name for name in ENGINES if find_spec(name)]:
            for scene in options.scenes:
                world = Path(folder) / "scene.yaml"
                world.write_text(scenes()[scene], encoding="utf-8")
                rounds = asyncio.run(measure_scene(name, world, options.rounds))
                kinds = list(zip(*rounds, strict=True))
                (bare, _), *others = (
                    (statistics.median(rate for rate, _ in kind), statistics.median(a / b for a, b in kind))
                    for kind in kinds
                )
                figures = "".join(f"{rate:8.0f} {share:4.0%} " for rate, share in others)
                print(f"{name:10}{scene:17}{bare:7.0f}{figures}", flush=True)
            rates = [asyncio.run(measure_navigation(name)) for _ in range(3)]
            scans = [measure_scan(name) for _ in range(5)]
            navigating, scan = statistics.median(rates), statistics.median(scans)
            print(f"{name:10}navigates: {navigating:.0f}; a scan takes {scan:.2f} ms")


if __name__ == "__main__":
    main()
