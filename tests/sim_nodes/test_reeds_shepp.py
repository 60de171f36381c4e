from __future__ import annotations

import numpy as np
import pytest

from sim_nodes.geometry import Array
from sim_nodes.navigation.lattice import relative
from sim_nodes.navigation.mobility import CarMobility
from sim_nodes.navigation.reeds_shepp import shortest_words


def some_poses(count: int = 200, seed: int = 0) -> Array:
    chance = np.random.default_rng(seed)
    return np.column_stack([*chance.uniform(-4.0, 4.0, (2, count)), chance.uniform(-np.pi, np.pi, count)])


@pytest.mark.parametrize(
    ("end", "length"),
    [
        ((3.0, 0.0, 0.0), 3.0),
        ((-3.0, 0.0, 0.0), 3.0),
        ((0.0, 2.0, np.pi), np.pi),  # half a circle
        ((0.0, 0.0, np.pi), np.pi),  # a turn in three pieces
        ((1.0, 1.0, np.pi / 2.0), np.pi / 2.0),
    ],
)
def test_simple_paths_have_the_known_length(end: tuple[float, float, float], length: float) -> None:
    assert shortest_words(np.array([end]), 1.0).costs[0] == pytest.approx(length)


def test_no_path_over_a_third_pose_is_shorter() -> None:
    ends, others = some_poses(), some_poses(seed=1)
    direct = shortest_words(ends, 1.0).costs
    over = shortest_words(others, 1.0).costs + shortest_words(relative(others, ends), 1.0).costs
    assert (direct <= over + 1e-6).all()
    assert (direct >= np.hypot(ends[:, 0], ends[:, 1]) - 1e-9).all()


def test_the_way_back_is_as_long() -> None:
    ends = some_poses()
    back = relative(ends, np.zeros(3))
    assert shortest_words(back, 1.0).costs == pytest.approx(shortest_words(ends, 1.0).costs)


def test_driving_backwards_may_cost_more() -> None:
    end = np.array([(-1.0, 0.0, 0.0)])
    assert shortest_words(end, 2.0).costs[0] == pytest.approx(2.0)
    assert (shortest_words(some_poses(), 3.0).costs >= shortest_words(some_poses(), 1.0).costs).all()


def test_connections_of_cars_keep_the_turning_radius() -> None:
    car = CarMobility(0.6, 2.0)
    for end in some_poses(20):
        poses = np.vstack([np.zeros(3), car.connection(end)])
        assert poses[-1] == pytest.approx(end)
        steps = np.diff(poses, axis=0)
        lengths = np.hypot(steps[:, 0], steps[:, 1])
        assert lengths.max() < 0.0501
        turned = np.abs((steps[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)
        assert (turned <= lengths / 0.6 * 1.01 + 1e-6).all()
