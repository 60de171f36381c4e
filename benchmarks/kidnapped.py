"""Global localisation of a robot that was carried elsewhere, as in `scenarios/catalogue/kidnapped_robot.osc`.

    python benchmarks/kidnapped.py [--seeds N] [--first N]

In MuJoCo, in this process, without Zenoh: the robot turns in place until it is localised. It prints the seeds that
fail, the number of them, and the time that the search takes.
"""

from __future__ import annotations

import argparse
import statistics

from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.physics import BodyState
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import load_world

ROBOT = "turtlebot4"
ELSEWHERE = Pose2(0.2, 1.6, 1.2)
TURNING = 0.8  # [rad/s]
LATEST = 30.0  # [s]
CLOSE = 0.15  # [m]


def find_itself(seed: int) -> tuple[float, float]:
    """Return the time until the robot is localised [s], and the error of its pose [m]."""
    simulation = Simulation(MujocoEngine(), load_world("maze"), seed)
    base = simulation.robot(ROBOT).mobile
    base.set_initial_pose(Pose2(0.0, 0.0, 0.0), simulation.tick)
    x, y, yaw = ELSEWHERE
    simulation.move(ROBOT, BodyState((x, y, 0.001), quaternion(0.0, 0.0, yaw)))
    base.search_pose(simulation.tick)
    simulation.drive(ROBOT, "turn", Velocity(0.0, TURNING), LATEST)
    while base.localised_pose() is None and simulation.time < LATEST:
        simulation.run(simulation.time + 0.1)
    found, truth = base.localised_pose(), simulation.frames.true_pose(ROBOT)
    return simulation.time, float("inf") if found is None else found.distance(truth.x, truth.y)


def main() -> None:
    """Search and print."""
    parser = argparse.ArgumentParser(description="Measure the global localisation of a kidnapped robot.")
    parser.add_argument("--seeds", type=int, default=300, metavar="N")
    parser.add_argument("--first", type=int, default=1000, metavar="N")
    options = parser.parse_args()
    times, failed = [], 0
    for seed in range(options.first, options.first + options.seeds):
        time, error = find_itself(seed)
        times.append(time)
        if error > CLOSE:
            failed += 1
            print(f"seed {seed}: {error:.3f} m after {time:.1f} s", flush=True)
    print(f"{options.seeds - failed} of {options.seeds} found; median {statistics.median(times):.1f} s, ", end="")
    print(f"at most {max(times):.1f} s")


if __name__ == "__main__":
    main()
