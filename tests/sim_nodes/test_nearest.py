from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from sim_nodes.navigation.grid_search import connected_cells
from sim_nodes.navigation.nearest import nearest_cells


@pytest.mark.parametrize("seed", range(8))
def test_the_nearest_cells_are_those_of_scipy(seed: int) -> None:
    random = np.random.default_rng(seed)
    columns, rows = random.integers(8, 60, 2).tolist()
    empty = np.ones((columns, rows), dtype=np.bool_)
    empty[random.integers(0, columns, 20), random.integers(0, rows, 20)] = False
    cells = np.argwhere(~empty).T
    numbers = nearest_cells(cells, (columns, rows), 9)
    away, places = distance_transform_edt(empty, return_indices=True)
    assert ((numbers >= 0) == (away <= 9.0)).all()
    near = numbers >= 0
    assert (cells[:, numbers[near]] == places[:, near]).all()


def test_cells_are_connected_by_sides_and_corners() -> None:
    free = np.array([[1, 0, 0, 1], [0, 1, 0, 1], [0, 1, 0, 1]], dtype=np.bool_)
    region = connected_cells(free, (0, 0))
    assert region.tolist() == [
        [True, False, False, False],
        [False, True, False, False],
        [False, True, False, False],
    ]
    assert not connected_cells(free, (0, 1)).any()
