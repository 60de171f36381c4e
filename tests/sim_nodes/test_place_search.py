from __future__ import annotations

import math

import numpy as np

from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation.localisation import Localisation
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.place_search import best_places
from sim_nodes.noise import Noise
from sim_nodes.physics import Wall
from sim_nodes.sensors.lidar import Scan

WALLS = (
    Wall("a", 0.0, 2.9, 0.0, 5.8, 0.1, 0.5),
    Wall("b", 2.9, 0.0, math.pi / 2, 5.8, 0.1, 0.5),
    Wall("c", 0.0, -2.9, 0.0, 5.8, 0.1, 0.5),
    Wall("d", -2.9, 0.0, math.pi / 2, 5.8, 0.1, 0.5),
    Wall("e", -1.0, -1.0, 0.4, 2.0, 0.1, 0.5),
)
KNOWN = build_map((-3.0, -3.0, 3.0, 3.0), WALLS)


def rate(x: Array, y: Array) -> Array:
    distance: Array = KNOWN.distance[KNOWN.grid.cells(x, y)]
    return -((distance / 0.1) ** 2).clip(max=9.0)


def seen_from(truth: Pose2, known: NavigationMap = KNOWN) -> Scan:
    """Return the scan of the room at a pose, by small steps along the beams."""
    angles = np.linspace(-math.pi, math.pi, 120, endpoint=False)
    steps = np.arange(0.0, 9.0, 0.01)
    x = truth.x + steps[:, None] * np.cos(angles + truth.yaw)
    y = truth.y + steps[:, None] * np.sin(angles + truth.yaw)
    ranges = steps[(known.distance[known.grid.cells(x, y)] == 0.0).argmax(axis=0)]
    return Scan(ranges, angles, Pose2(0.0, 0.0, 0.0), ranges * np.cos(angles), ranges * np.sin(angles))


def test_the_best_place_is_the_true_one_among_alike_corners() -> None:
    truth = Pose2(1.6, 1.4, 0.7)
    points = KNOWN.grid.points(np.argwhere(KNOWN.distance > 0.2)[::3])
    best, second, *_ = best_places(points, seen_from(truth), rate)
    assert best.pose.distance(truth.x, truth.y) < 0.06
    assert abs(best.pose.yaw - truth.yaw) < 0.05
    assert not second.is_same(best.pose)
    assert second.fit < best.fit - 0.1


def test_a_search_does_not_choose_among_alike_places() -> None:
    """A square room has four places that are alike, unless there is a mark at a wall."""
    truth, still = Pose2(1.6, 1.4, 0.7), Pose2(0.0, 0.0, 0.0)

    def found_with(walls: tuple[Wall, ...]) -> Pose2 | None:
        known = build_map((-3.0, -3.0, 3.0, 3.0), walls)
        localisation = Localisation(known, BASE, Noise(0, "test"))
        localisation.search(still, 0)
        localisation.particles = np.array(truth) + np.random.default_rng(0).normal(0.0, 0.02, (500, 3))
        localisation.update(still, seen_from(truth, known), 1)
        return localisation.pose(still)

    assert found_with(WALLS[:4]) is None
    found = found_with(WALLS)
    assert found is not None and found.distance(truth.x, truth.y) < 0.1
