"""Times for which native code of the engines keeps other threads from running: loading, steps and pictures.

    PYTHONPATH=. python benchmarks/held_lock.py [--engines mujoco,pybullet] [--boxes 0,200,1000]

A thread wakes up each millisecond, as that of emergency stops does when a message has come, and notes how late it
was at most. Meanwhile the main thread loads a world, spawns boxes in a heap, makes steps one by one, simulates a
tick, and draws the largest picture. For each, it prints how long one call took at most, and how late the thread
was. Last, the main thread draws and simulates in turns, while a thread halts it at random moments, and it prints
how much time had passed in the simulation from these moments on.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Callable

from seoro.bridges import wire
from sim_nodes import verbs
from sim_nodes.node import SWITCH_INTERVAL
from sim_nodes.simulator import Simulator
from sim_nodes.views import MAX_SIZE, Lens, View, looking_at
from tests.sim_nodes.client import BOX, pose
from tests.sim_nodes.engines import make_engine

PERIOD = 0.001  # [s]
STEPS, TICKS, PICTURES = 50, 10, 2
HEIGHT = 8.0  # [m] of the camera
DELAYS = (0.3, 0.7, 1.1, 1.9)  # [s] until a halt


class Sleeper:
    """A thread that notes how late it wakes up at most [s]."""

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
        """Call something several times, and print how long that took at most, and how late the thread was."""
        self.latest, longest = 0.0, 0.0
        for _ in range(times):
            began = time.monotonic()
            call()
            longest = max(longest, time.monotonic() - began)
        time.sleep(2 * PERIOD)
        print(f"  {what}: {longest * 1e3:.1f} ms, thread late by {self.latest * 1e3:.1f} ms", flush=True)


def heap(count: int) -> wire.SpawnEntities:
    """Boxes above each other, in towers of ten that fall into each other."""
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
    """Draw and simulate until a thread halts that; return what was simulated since it should have [s]."""
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
    simulator.go_on()
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
