"""Global localisation of a robot that was carried elsewhere, as in `scenarios/catalogue/kidnapped_robot.osc`.

    python benchmarks/kidnapped.py [--engine ENGINE] [--results FILE] [--seeds N] [--first N]

In this process, without Zenoh: the robot turns in place until it is localised. It prints the seeds that fail, the
number of the others, and the time that the search takes. Runs are appended to the results, a file of JSON lines,
and not repeated. After a change of the code, name a new file.
"""

from __future__ import annotations

import argparse
import math
import statistics
from dataclasses import dataclass
from pathlib import Path

from results import read_results, write_result

from sim_nodes.__main__ import ENGINES
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.physics import BodyState
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import load_world

ROBOT = "turtlebot4"
ELSEWHERE = Pose2(0.2, 1.6, 1.2)
TURNING = 0.8  # [rad/s]
LATEST = 30.0  # [s]
CLOSE = 0.15  # [m]


@dataclass(frozen=True)
class Search:
    """Result of a search.

    Args:
        engine: The engine.
        seed: Its seed.
        time: Until the robot is localised [s].
        error: Error of its position [m]; infinite if it is not localised.
    """

    engine: str
    seed: int
    time: float
    error: float

    @property
    def failed(self) -> bool:
        """Whether the robot did not find itself."""
        return self.error > CLOSE


def find_itself(engine: str, seed: int) -> Search:
    """Search once."""
    simulation = Simulation(ENGINES[engine](), load_world("maze"), seed)
    base = simulation.robot(ROBOT).mobile
    base.set_initial_pose(Pose2(0.0, 0.0, 0.0), simulation.tick)
    x, y, yaw = ELSEWHERE
    simulation.move(ROBOT, BodyState((x, y, 0.001), quaternion(0.0, 0.0, yaw)))
    base.search_pose(simulation.tick)
    simulation.drive(ROBOT, "turn", Velocity(0.0, TURNING), LATEST)
    while base.localised_pose() is None and simulation.time < LATEST:
        simulation.run(simulation.time + 0.1)
    found, truth = base.localised_pose(), simulation.frames.true_pose(ROBOT)
    error = math.inf if found is None else found.distance(truth.x, truth.y)
    return Search(engine, seed, simulation.time, error)


def main() -> None:
    """Search and print."""
    parser = argparse.ArgumentParser(description="Measure the global localisation of a kidnapped robot.")
    parser.add_argument("--engine", choices=list(ENGINES), default="mujoco")
    parser.add_argument("--results", type=Path, default=Path("kidnapped.jsonl"), metavar="FILE")
    parser.add_argument("--seeds", type=int, default=300, metavar="N")
    parser.add_argument("--first", type=int, default=1000, metavar="N")
    options = parser.parse_args()
    done = {search.seed for search in read_results(options.results, Search) if search.engine == options.engine}
    with options.results.open("a", encoding="utf-8") as out:
        for seed in range(options.first, options.first + options.seeds):
            if seed not in done:
                search = find_itself(options.engine, seed)
                write_result(out, search)
                if search.failed:
                    print(f"seed {seed}: {search.error:.3f} m after {search.time:.1f} s", flush=True)
    searches = [search for search in read_results(options.results, Search) if search.engine == options.engine]
    times = [search.time for search in searches]
    found = sum(not search.failed for search in searches)
    print(f"{options.engine}: {found} of {len(searches)} found; ", end="")
    print(f"median {statistics.median(times):.1f} s, at most {max(times):.1f} s")


if __name__ == "__main__":
    main()
