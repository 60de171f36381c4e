from __future__ import annotations

import numpy as np
import pytest

from sim_nodes.geometry import Array
from sim_nodes.manipulation.motion import SHORTEST, Path, Trajectory
from tests.sim_nodes.manipulation.bench import HOME

SPEED = np.array([2.0, 2.0, 3.0, 3.0, 3.0, 3.0])
ACCELERATION = np.full(6, 5.0)
WAY = np.array([1.0, -0.5, 0.3, 0.0, 2.0, -0.1])


def samples(trajectory: Trajectory) -> tuple[Array, Array, Array, Array]:
    times = np.linspace(0.0, trajectory.duration, 2001)
    moments = [trajectory.at(float(time)) for time in times]
    positions = np.array([moment.positions for moment in moments])
    velocities = np.array([moment.velocities for moment in moments])
    return times, positions, velocities, np.gradient(velocities, times, axis=0)


@pytest.mark.parametrize("share", [1.0, 0.1])
@pytest.mark.parametrize("waypoints", [(), (HOME + np.array([0.2, 0.3, 0.3, 0.0, 0.1, 0.1]), HOME + 0.4)])
def test_a_trajectory_reaches_one_limit_and_exceeds_none(share: float, waypoints: tuple[Array, ...]) -> None:
    trajectory = Trajectory(Path([HOME, *waypoints, HOME + WAY]), share * SPEED, ACCELERATION)
    _, _, velocities, accelerations = samples(trajectory)
    speed = np.abs(velocities / (share * SPEED)).max()
    acceleration = np.abs(accelerations / ACCELERATION).max()
    assert speed <= 1.001
    assert acceleration <= 1.1  # of a path with corners, differences across them
    assert max(speed, acceleration) > 0.99


def test_a_trajectory_passes_all_waypoints_from_rest_to_rest() -> None:
    points = [HOME, HOME + 0.3, HOME + np.array([0.3, 0.0, 0.5, 0.1, 0.0, 0.2])]
    path = Path(points)
    trajectory = Trajectory(path, SPEED, ACCELERATION)
    for time, point in (
        (0.0, points[0]),
        (trajectory.duration, points[-1]),
        (trajectory.duration + 1, points[-1]),
    ):
        moment = trajectory.at(time)
        np.testing.assert_allclose(moment.positions, point, atol=1e-12)
        np.testing.assert_allclose(moment.velocities, 0.0, atol=1e-12)
    for knot, point in zip(path.knots.tolist(), points, strict=True):
        np.testing.assert_allclose(path.at(knot), point, atol=1e-12)


def test_velocities_are_derivatives_of_positions() -> None:
    points = [HOME, HOME + 0.3, HOME + np.array([0.3, 0.0, 0.5, 0.1, 0.0, 0.2])]
    times, positions, velocities, _ = samples(Trajectory(Path(points), SPEED, ACCELERATION))
    np.testing.assert_allclose(np.gradient(positions, times, axis=0), velocities, atol=0.02)


def test_joints_stay_between_neighbouring_waypoints() -> None:
    points = np.array([HOME, HOME + 1.0, HOME + 1.01, HOME])
    path = Path(list(points))
    found = np.array([path.at(place) for place in np.linspace(0.0, 1.0, 500)])
    assert np.all(found >= points.min(axis=0) - 1e-12)
    assert np.all(found <= points.max(axis=0) + 1e-12)


def test_a_path_without_length_has_a_minimum_duration() -> None:
    trajectory = Trajectory(Path([HOME, HOME]), SPEED, ACCELERATION)
    assert trajectory.duration == SHORTEST
    np.testing.assert_array_equal(trajectory.at(0.02).positions, HOME)
