"""Rules for rendering, and for the poses of links. Engines that do not render here (`NoRendering`) pass."""

from __future__ import annotations

import itertools
import math
from contextlib import suppress

import numpy as np

from sim_nodes.check.bench import (
    BASE,
    CUBE,
    EDGE,
    ORIGIN,
    ROBOT,
    Make,
    at,
    body,
    built,
    drive,
    expect,
    expect_near,
    run,
)
from sim_nodes.geometry import Array, Pose2, quaternion, yaw_of
from sim_nodes.physics import BodyState
from sim_nodes.views import Lens, NoRendering, Picture, View

LIDAR = BASE.lidar
LENS = Lens(math.radians(40.0), 320, 240)
HEIGHT = 10.0  # [m] of a camera that sees only the sky
SKYWARDS = View((-3.0, 0.0, HEIGHT), quaternion(0.0, 0.0, 0.0), LENS)
CLOSE = 1.2  # [pixels]
VISIBLE = 8  # of 255; minimum change of a pixel


def _changed(before: Picture, after: Picture) -> tuple[Array, Array]:
    """Return rows and columns of the pixels in which two images differ."""
    rows, columns = np.nonzero(np.abs(before.astype(int) - after.astype(int)).max(axis=2) > VISIBLE)
    return rows.astype(np.float64), columns.astype(np.float64)


def _expect_cube(what: str, before: Picture, after: Picture, x: float, y: float, z: float) -> None:
    """Expect a cube in one of two images where a pinhole camera projects its corners."""
    rows, columns = _changed(before, after)
    expect(len(rows) > 0, f"{what} at ({x}, {y}, {z}) is not seen from {SKYWARDS.position}")
    corners = np.add(list(itertools.product((-EDGE / 2, EDGE / 2), repeat=3)), (x, y, z))
    ahead, left, up = (corners - SKYWARDS.position).T  # the camera looks along x
    scale = LENS.height / 2 / math.tan(LENS.fov / 2)
    row, column = LENS.height / 2 - scale * up / ahead, LENS.width / 2 - scale * left / ahead
    found = (rows.min(), rows.max() + 1, columns.min(), columns.max() + 1)
    wanted = (row.min(), row.max(), column.min(), column.max())
    expect_near(f"first and last row and column of {what} at ({x}, {y}, {z})", found, wanted, CLOSE)


def images_show_bodies_at_their_poses(make: Make) -> None:
    """An image has rows from the top, columns from the left, and a vertical field of view."""
    engine = built(make)
    with suppress(NoRendering):
        before = engine.render(SKYWARDS)
        shape = (LENS.height, LENS.width, 3)
        found = f"it is an array of {before.dtype} and shape {before.shape}, not uint8 and {shape}"
        expect(before.shape == shape and before.dtype == np.uint8, found)
        for y, z in ((0.0, HEIGHT), (0.8, HEIGHT + 0.5), (-1.0, HEIGHT - 0.6)):
            engine.add_body("cube", body(CUBE, static=True), at(0.0, y, z))
            _expect_cube("a cube", before, engine.render(SKYWARDS), 0.0, y, z)
            engine.remove_body("cube")


def images_show_the_present(make: Make) -> None:
    """Images show the present poses of bodies that were set or that move."""
    engine = built(make)
    with suppress(NoRendering):
        empty = engine.render(SKYWARDS)
        engine.add_body("cube", body(CUBE), at(0.0, 0.0, HEIGHT))
        engine.set_body_state("cube", at(0.0, 0.5, HEIGHT + 0.6))
        _expect_cube("a cube that was moved", empty, engine.render(SKYWARDS), 0.0, 0.5, HEIGHT + 0.6)
        run(engine, 0.4)
        picture = engine.render(SKYWARDS)
        _expect_cube("a cube that falls", empty, picture, *engine.body_state("cube").position)


def rendering_changes_nothing(make: Make) -> None:
    """Rendering leaves the states of a run bit-identical."""
    rendered, other = (built(make, ORIGIN) for _ in range(2))
    for engine in (rendered, other):
        engine.add_body("cube", body(CUBE), BodyState((0.6, 0.05, 0.5), quaternion(0.3, 0.2, 0.1)))
        drive(engine, 0.3, 0.2)
    with suppress(NoRendering):
        for index in range(1, 16):
            run(rendered, 0.1)
            run(other, 0.1)
            rendered.link_pose(ROBOT, LIDAR.link)
            rendered.render(SKYWARDS)
            for name in (ROBOT, "cube"):
                found, wanted = rendered.body_state(name), other.body_state(name)
                what = f"rendering has changed the state at {0.1 * index:.1f} s: {found} instead of {wanted}"
                expect(found == wanted, what)


def links_keep_their_mounts(make: Make) -> None:
    """Links of a robot keep their pose relative to the base within 1 mm, also in motion."""
    engine = built(make, ORIGIN)
    drive(engine, 0.2, 1.5)
    for _ in range(5):
        run(engine, 0.2)
        base = engine.body_state(ROBOT).planar
        wanted = base.compose(Pose2(LIDAR.x, LIDAR.y, LIDAR.yaw))
        (x, y, _), orientation = engine.link_pose(ROBOT, LIDAR.link)
        expect_near("x and y of the lidar's link [m]", (x, y), (wanted.x, wanted.y), 2e-3)
        turn = math.remainder(yaw_of(orientation) - wanted.yaw, 2 * math.pi)
        expect_near("the yaw of the lidar's link off its mount [rad]", turn, 0.0, 1e-2)
