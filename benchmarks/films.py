"""Cost of images and videos of simulators, in processor time.

    python benchmarks/films.py [ENGINE ...] [--rounds N]

All of the whole world `maze`, in which a TurtleBot 4 drives in a circle. Rounds take turns between the sizes, and
figures are the medians of all rounds.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from functools import partial

from seoro.bridges.wire import StartRecording
from sim_nodes.__main__ import ENGINES
from sim_nodes.cameras import png
from sim_nodes.physics import Engine
from sim_nodes.simulator import Simulator
from sim_nodes.views import Lens, View, overview

SIZES = ((320, 240), (640, 360), (640, 480), (1280, 720))
PICTURES = 5
RATE = 25  # [Hz]
SECONDS = 2.0  # of simulated time in a round
ROBOT = "turtlebot4"


def spent(act: Callable[[], object]) -> float:
    """Processor time [s]."""
    start = time.process_time()
    act()
    return time.process_time() - start


def draw(engine: Engine, view: View) -> None:
    """Take pictures."""
    for _ in range(PICTURES):
        engine.render(view)


def measure_pictures(simulator: Simulator, rounds: int) -> None:
    """Print what a picture costs in each size."""
    simulation = simulator.simulation
    costs: dict[tuple[int, int], list[float]] = {size: [] for size in SIZES}
    for _ in range(rounds):
        for width, height in SIZES:
            view = overview(simulation.world.extent, 0.5, Lens(width=width, height=height))
            simulation.engine.render(view)  # the first of a size is slower
            cost = spent(partial(draw, simulation.engine, view))
            costs[width, height].append(cost / PICTURES)
    for (width, height), found in costs.items():
        print(f"  a picture of {width} by {height}: {1e3 * statistics.median(found):.0f} ms")
    picture = simulation.engine.render(overview(simulation.world.extent, 0.5, Lens()))
    cost, size = spent(lambda: png(picture)), len(png(picture))
    print(f"  the PNG of one of 640 by 480: {1e3 * cost:.0f} ms, {size // 1000} kB")


def measure_films(simulator: Simulator, rounds: int) -> None:
    """Print what a second of simulated time costs, with a film and without, and how large films are."""
    simulation = simulator.simulation
    plain, filmed, size = [], [], 0
    for _ in range(rounds):
        plain.append(spent(lambda: simulator.advance(simulation.time + SECONDS, None)) / SECONDS)
        simulation.recording.start(StartRecording(rate=RATE))
        parts: list[bytes] = []

        def record(parts: list[bytes] = parts) -> None:
            end = simulation.time + SECONDS
            while simulation.time < end:
                parts.append(simulator.advance(min(end, simulation.time + 0.2), None).film)

        filmed.append(spent(record) / SECONDS)
        parts.append(simulation.recording.stop()[0])
        size = sum(map(len, parts))
    print(f"  a simulated second: {statistics.median(plain):.3f} s, filmed {statistics.median(filmed):.2f} s")
    print(f"  a second of film: {size / SECONDS / 1000:.0f} kB")


def main() -> None:
    """Measure the engines that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("engine", nargs="*", default=sorted(ENGINES))
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    for name in options.engine:
        simulator = Simulator(ENGINES[name](), "maze", 0)
        simulator.simulation.engine.command_wheels(ROBOT, 3.0, 6.0)
        print(name)
        measure_pictures(simulator, options.rounds)
        measure_films(simulator, options.rounds)


if __name__ == "__main__":
    main()
