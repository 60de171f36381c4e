from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from sim_nodes.geometry import roll_pitch_yaw, rotation_matrix
from sim_nodes.views import Lens, View, looking_at, overview


def seen_at(view: View, point: tuple[float, float, float]) -> tuple[float, float]:
    """Return the position of a point in an image, from -1 to 1 from the left and from the top."""
    ahead, left, up = rotation_matrix(view.orientation).T @ np.subtract(point, view.position)
    half = math.tan(view.lens.fov / 2)
    return -left / ahead / (half * view.lens.aspect), -up / ahead / half


@pytest.mark.parametrize("target", [(1.0, 2.0, 0.5), (-3.0, 0.1, 4.0), (0.2, 0.3, -5.0), (0.2, 0.3, 5.0)])
def test_a_camera_is_upright_with_its_target_in_the_middle(
    target: tuple[float, float, float],
) -> None:
    position = (0.2, 0.3, 1.0)
    view = View(position, looking_at(position, target), Lens())
    assert seen_at(view, target) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert roll_pitch_yaw(view.orientation)[0] == pytest.approx(0.0, abs=1e-6) or target[:2] == position[:2]
    _, up = view.axes
    assert up[2] >= -1e-9


def test_straight_down_the_top_of_the_picture_is_towards_y() -> None:
    view = View((1.0, 1.0, 5.0), looking_at((1.0, 1.0, 5.0), (1.0, 1.0, 0.0)), Lens())
    right, down = seen_at(view, (1.5, 1.2, 0.0))
    assert right > 0.0 > down


@pytest.mark.parametrize("extent", [(-5.0, -5.0, 5.0, 5.0), (0.0, -1.0, 20.0, 1.0), (3.0, 0.0, 4.0, 30.0)])
@pytest.mark.parametrize("lens", [Lens(), Lens(width=960, height=540), Lens(width=300, height=600)])
def test_an_overview_fits_the_whole_world_closely(extent: tuple[float, float, float, float], lens: Lens) -> None:
    left, bottom, right, top = extent
    view = overview(extent, 0.5, lens)
    corners = np.array(
        [seen_at(view, corner) for corner in itertools.product((left, right), (bottom, top), (0.0, 0.5))]
    )
    assert np.abs(corners).max() < 1.0
    assert np.ptp(corners, axis=0).max() > 1.8, "it fills the picture in one direction"
    assert corners.sum(axis=0) / 8 == pytest.approx((0.0, 0.0), abs=0.3)


def test_an_overview_includes_other_points() -> None:
    extent = (-1.0, -1.0, 1.0, 1.0)
    high = (0.2, 0.5, 2.5)
    assert np.abs(seen_at(overview(extent, 0.5, Lens()), high)).max() > 1.0
    assert np.abs(seen_at(overview(extent, 0.5, Lens(), [high]), high)).max() < 1.0
