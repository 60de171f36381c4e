"""Global localisation of a robot in the maze, and the effect of lidar noise on navigation.

    python benchmarks/localisation.py [--places N] [--seeds N]

Both in MuJoCo, in this process, without Zenoh. The second part drives through the maze with noise in the ranges:
as in nodes, and without the two measures against noise. These are the number of hits that make an obstacle, and
the number of adjacent beams that indicate one ahead.
"""

from __future__ import annotations

import argparse
import math
import statistics

import numpy as np

from seoro.bridges.wire import GaussianNoise, Occurrence, Quantity
from seoro.campaign.statistics.rates import fixed_bounds
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.navigation import arcs, obstacles
from sim_nodes.navigation.goals import Goal
from sim_nodes.physics import BodyState
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.simulator import Simulator

ROBOT = "turtlebot4"
TURNING = 0.8  # [rad/s]
GIVEN_UP = 30.0  # [s]
FOUND = 0.2  # [m]
GOAL = Pose2(3.0, -3.0, 0.0)
LATEST = 90.0  # [s]


def place(number: int) -> Pose2:
    """A place in the maze: one in two anywhere, the others in the middle of where corridors meet."""
    random = np.random.default_rng(number)
    x, y = random.integers(-3, 4, 2) * 1.5
    if number % 2:
        x, y = x + random.uniform(-0.4, 0.4), y + random.uniform(-0.4, 0.4)
    return Pose2(float(x), float(y), float(random.uniform(-math.pi, math.pi)))


def find_itself(number: int) -> tuple[float, float]:
    """Return the time until a robot is localised [s], and the error of its pose [m]."""
    simulator = Simulator(MujocoEngine(), "maze", number)
    simulation = simulator.simulation
    start = place(number)
    state = BodyState((start.x, start.y, 0.001), quaternion(0.0, 0.0, start.yaw))
    simulation.engine.set_body_state(ROBOT, state)
    base = simulation.robot(ROBOT).mobile
    simulation.robot(ROBOT).mobile.search_pose(simulation.tick)
    simulation.drive(ROBOT, "turn", Velocity(0.0, TURNING), GIVEN_UP)
    while base.localised_pose() is None and simulation.time < GIVEN_UP:
        simulation.advance(simulation.time + 0.1)
    found, truth = base.localised_pose(), simulation.frames.true_pose(ROBOT)
    return simulation.time, math.inf if found is None else found.distance(truth.x, truth.y)


def drive(std: float, seed: int) -> tuple[str, float, float, float]:
    """Drive through the maze; return the status, duration [s], length [m] and mean error [m]."""
    simulator = Simulator(MujocoEngine(), "maze", seed)
    simulation = simulator.simulation
    simulation.robot(ROBOT).mobile.set_initial_pose(Pose2(0.0, 0.0, 0.0), simulation.tick)
    simulation.inject_fault("noise", ROBOT, "lidar", GaussianNoise(deviation={Quantity.LENGTH: std}), LATEST)
    simulation.navigate(ROBOT, Goal("goal", (GOAL,), stop_at_each=False))
    ended = "under way"
    while ended == "under way" and simulation.time < LATEST:
        simulation.advance(LATEST)
        ends = {each.id: each.outcome.value for each in simulation.collect() if isinstance(each, Occurrence)}
        ended = ends.get("goal", ended)
    measured = simulation.measurements().robots[ROBOT]
    return ended, simulation.time, measured.path_length, measured.localisation_error or 0.0


def _open(ranges: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return ranges as they are, in place of `arcs._closed`."""
    return ranges


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument("--places", type=int, default=60, metavar="N")
    parser.add_argument("--seeds", type=int, default=30, metavar="N")
    options = parser.parse_args()

    results = [find_itself(number) for number in range(options.places)]
    found = [time for time, error in results if error < FOUND]
    wrong = sum(1 for _, error in results if FOUND <= error < math.inf)
    print(f"{len(found)} of {options.places} found themselves, {wrong} elsewhere")
    print(f"in {statistics.median(found):.1f} s (median), {max(found):.1f} s at most\n")

    print("noise  count  neighbours  arrived    95 % confidence  path, median and range     error, mean")
    hits, most, neighbours, closed = obstacles.HITS, obstacles.MOST, arcs.NEIGHBOURS, arcs._closed
    for count, agree in ((True, True), (False, True), (True, False), (False, False)):
        obstacles.HITS, obstacles.MOST = (hits, most) if count else (1, 1)
        arcs.NEIGHBOURS = neighbours if agree else 1
        arcs._closed = closed if agree else _open
        for std in (0.2, 0.4, 0.6):
            runs = [drive(std, seed) for seed in range(options.seeds)]
            arrived = sum(ended == "succeeded" for ended, *_ in runs)
            bounds = fixed_bounds(arrived, len(runs))
            paths = sorted(path for _, _, path, _ in runs)
            words = f"{'yes' if count else 'no':5}  {'yes' if agree else 'no':10}"
            print(
                f"{std:4} m  {words}  {arrived:3} of {len(runs):3}  {bounds.low:7.1%} to {bounds.high:6.1%}  "
                f"{statistics.median(paths):5.1f} m, {paths[0]:.1f} to {paths[-1]:.1f} m  "
                f"{statistics.mean(error for *_, error in runs):.3f} m",
                flush=True,
            )


if __name__ == "__main__":
    main()
