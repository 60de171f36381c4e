from __future__ import annotations

import math

import numpy as np

from seoro.bridges.wire import GET_RELATIVE_POSE, RelativePose
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.grid import build_map
from sim_nodes.navigation.localisation import Localisation
from sim_nodes.noise import Noise
from tests.sim_nodes.client import ROBOT, TRUTH, Client, pose


def test_the_localisation_stays_within_bounds_while_driving(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, -1.5))
    errors = []
    for _ in range(40):
        maze.advance(maze.simulator.simulation.time + 0.5)
        errors.append(maze.estimate.distance(maze.truth.x, maze.truth.y))
    assert maze.truth.distance(0.0, 0.0) > 1.0
    assert float(np.mean(errors)) < 0.05
    assert max(errors) < 0.12


def test_a_wrong_initial_pose_is_corrected_by_the_scans(maze: Client) -> None:
    maze.localise(pose(0.1, -0.1, 0.05))
    assert maze.estimate.distance(0.1, -0.1) < 1e-9
    maze.navigate(pose(1.5, 1.5))
    maze.run_until("goal")
    assert maze.estimate.distance(maze.truth.x, maze.truth.y) < 0.08


def test_without_scans_that_fit_the_odometry_carries_the_estimate() -> None:
    localisation = Localisation(build_map((-5, -5, 5, 5), ()), 12.0, Noise(0, "test"))
    odometry = Pose2(1.0, 0.0, 0.0)
    assert localisation.pose(odometry) is None
    assert localisation.map_to_odom() is None
    localisation.set_initial_pose(Pose2(0.0, 2.0, math.pi / 2), odometry, 0)
    moved = localisation.pose(Pose2(2.0, 0.0, 0.0))
    assert moved is not None
    assert moved.distance(0.0, 3.0) < 1e-9


def test_frames_know_the_estimate_and_the_truth_apart(empty: Client) -> None:
    empty.localise(pose(2.0, 1.0, math.pi / 2))

    def ahead(frame: str, parent: str = "map") -> tuple[float, float, float]:
        found = empty.ask(GET_RELATIVE_POSE, RelativePose(frame=frame, parent_frame=parent, distance=1.0))
        return round(found.position.x, 3), round(found.position.y, 3), round(found.orientation.yaw, 3)

    assert ahead(f"{ROBOT}/base_link") == (2.0, 2.0, 1.571)
    assert ahead("base_link", "odom") == (1.0, 0.0, 0.0)
    assert ahead(TRUTH) == (1.0, 0.0, 0.0)
