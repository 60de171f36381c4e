"""Times for which native code of the engines keeps other threads from running: loading, steps and pictures.

    PYTHONPATH=. python benchmarks/held_lock.py [--engines mujoco,pybullet] [--boxes 0,200,1000]

A thread wakes up each millisecond, as the thread of emergency stops on a message, and records its maximum delay.
Meanwhile the main thread loads a world, spawns boxes in a heap, makes single steps, simulates a tick, and renders
the largest image. For each, the maximum duration of a call and the delay of the thread are printed. Last, the main
thread renders and simulates in turns, while a thread halts it at random moments. The simulated time after these
moments is printed.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Callable

from seoro.bridges import wire
from seoro.bridges.serving.emergency import SWITCH_INTERVAL
from sim_nodes import verbs
from sim_nodes.simulator import Simulator
from sim_nodes.views import MAX_SIZE, Lens, View, looking_at
from tests.sim_nodes.client import BOX, pose
from tests.sim_nodes.engines import make_engine

PERIOD = 0.001  # [s]
STEPS, TICKS, PICTURES = 50, 10, 2
HEIGHT = 8.0  # [m] of the camera
DELAYS = (0.3, 0.7, 1.1, 1.9)  # [s] until a halt


class Sleeper:
    """A thread that records its maximum wake-up delay [s]."""

    def __init__(self) -> None:
        self.latest = 0.0
        self._over = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        while not self._over.is_set():
            began = time.monotonic()
            time.sleep(PERIOD)
            self.latest = max(self.latest, time.monotonic() - began - PERIOD)

    def measure(self, what: str, call: Callable[[], object], times: int) -> None:
        """Call a function several times; print its maximum duration, and the delay of the thread."""
        self.latest, longest = 0.0, 0.0
        for _ in range(times):
            began = time.monotonic()
            call()
            longest = max(longest, time.monotonic() - began)
        time.sleep(2 * PERIOD)
        print(f"  {what}: {longest * 1e3:.1f} ms, thread late by {self.latest * 1e3:.1f} ms", flush=True)


def heap(count: int) -> wire.SpawnEntities:
    """Return boxes in towers of ten that fall into each other."""
    return wire.SpawnEntities(
        entities=tuple(
            wire.SpawnEntity(
                name=f"box{number}",
                uri="box.sdf",
                resource_string=BOX,
                initial_pose=pose(
                    -4.0 + number // 10 % 10 * 0.7, -3.0 + number // 100 * 0.6, z=0.3 + number % 10 * 0.5
                ),
            )
            for number in range(count)
        )
    )


def measure(name: str, boxes: int) -> None:
    """Measure an engine with a heap of boxes."""
    print(f"{name}, {boxes} boxes")
    sleeper, made = Sleeper(), list[Simulator]()
    sleeper.measure("load the world", lambda: made.append(Simulator(make_engine(name), "hall", 0)), 1)
    (simulator,) = made
    engine, simulation = simulator.simulation.engine, simulator.simulation
    if boxes:
        bodies = heap(boxes).entities

        request = wire.encode(wire.SpawnEntities(entities=bodies))
        sleeper.measure("spawn the boxes", lambda: verbs.handle(simulator, wire.SPAWN_ENTITIES.name, request), 1)
        simulation.step(200)  # they fall
    sleeper.measure("one step", lambda: engine.step(1), STEPS)
    sleeper.measure("a tick", lambda: simulation.run(simulator.time + 0.02), TICKS)
    place = (0.0, -HEIGHT, HEIGHT)
    view = View(place, looking_at(place, (0.0, 0.0, 0.0)), Lens(width=MAX_SIZE, height=MAX_SIZE))
    sleeper.measure("the largest picture", lambda: engine.render(view), PICTURES)
    passed = [halt_between_pictures(simulator, view, delay) for delay in DELAYS]
    print(f"  simulated after the moment of a halt: {max(passed) * 1e3:.1f} ms", flush=True)


def halt_between_pictures(simulator: Simulator, view: View, delay: float) -> float:
    """Render and simulate until a thread halts it; return the simulated time after the halt [s]."""
    at = time.monotonic() + delay

    def halt() -> None:
        time.sleep(max(0.0, at - time.monotonic()))
        simulator.halt()

    simulation, passed = simulator.simulation, [(time.monotonic(), simulator.time)]
    threading.Thread(target=halt, daemon=True).start()
    while not simulation.halted.is_set():
        simulation.engine.render(view)
        passed.append((time.monotonic(), simulator.time))
        simulation.run(simulator.time + 0.02)
        passed.append((time.monotonic(), simulator.time))
    simulator.resume()
    return simulator.time - max(reached for when, reached in passed if when <= at)


def main() -> None:
    """Measure all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engines", default="mujoco,pybullet")
    parser.add_argument("--boxes", default="0,200,1000")
    options = parser.parse_args()
    sys.setswitchinterval(SWITCH_INTERVAL)
    for name in options.engines.split(","):
        for boxes in options.boxes.split(","):
            measure(name, int(boxes))


if __name__ == "__main__":
    main()
