"""Rules about pictures, and about where links are. Engines that draw nothing here (`NoRendering`) keep them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

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
from sim_nodes.physics import BodyState, Engine
from sim_nodes.views import Lens, NoRendering, Picture, View

LIDAR = BASE.lidar
LENS = Lens(math.radians(40.0), 320, 240)
HEIGHT = 10.0  # [m] of a camera that sees the sky only
SKYWARDS = View((-3.0, 0.0, HEIGHT), quaternion(0.0, 0.0, 0.0), LENS)
CLOSE = 1.2  # [pixels]
VISIBLE = 8  # of 255, by which a pixel has changed


def _unless_blind(rule: Callable[[Engine], None], engine: Engine) -> None:
    try:
        rule(engine)
    except NoRendering:
        return


def _changed(before: Picture, after: Picture) -> tuple[Array, Array]:
    """Rows and columns of the pixels in which two pictures differ."""
    rows, columns = np.nonzero(np.abs(before.astype(int) - after.astype(int)).max(axis=2) > VISIBLE)
    return rows.astype(np.float64), columns.astype(np.float64)


def _expect_cube(what: str, before: Picture, after: Picture, x: float, y: float, z: float) -> None:
    """Expect a cube to be in one of two pictures where a pinhole camera has its corners."""
    rows, columns = _changed(before, after)
    expect(len(rows) > 0, f"{what} at ({x}, {y}, {z}) is not seen from {SKYWARDS.position}")
    corners = np.add(list(itertools.product((-EDGE / 2, EDGE / 2), repeat=3)), (x, y, z))
    ahead, left, up = (corners - SKYWARDS.position).T  # it looks along x
    scale = LENS.height / 2 / math.tan(LENS.fov / 2)
    row, column = LENS.height / 2 - scale * up / ahead, LENS.width / 2 - scale * left / ahead
    found = (rows.min(), rows.max() + 1, columns.min(), columns.max() + 1)
    wanted = (row.min(), row.max(), column.min(), column.max())
    expect_near(f"first and last row and column of {what} at ({x}, {y}, {z})", found, wanted, CLOSE)


def pictures_show_what_is_where(make: Make) -> None:
    """A picture has rows from the top, columns from the left, and a vertical field of view."""

    def rule(engine: Engine) -> None:
        before = engine.render(SKYWARDS)
        shape = (LENS.height, LENS.width, 3)
        found = f"it is an array of {before.dtype} and shape {before.shape}, not uint8 and {shape}"
        expect(before.shape == shape and before.dtype == np.uint8, found)
        for y, z in ((0.0, HEIGHT), (0.8, HEIGHT + 0.5), (-1.0, HEIGHT - 0.6)):
            engine.add_body("cube", body(CUBE, static=True), at(0.0, y, z))
            _expect_cube("a cube", before, engine.render(SKYWARDS), 0.0, y, z)
            engine.remove_body("cube")

    _unless_blind(rule, built(make))


def pictures_show_the_present(make: Make) -> None:
    """Pictures show what was moved and what moves by itself where it is now."""

    def rule(engine: Engine) -> None:
        empty = engine.render(SKYWARDS)
        engine.add_body("cube", body(CUBE), at(0.0, 0.0, HEIGHT))
        engine.set_body_state("cube", at(0.0, 0.5, HEIGHT + 0.6))
        _expect_cube("a cube that was moved", empty, engine.render(SKYWARDS), 0.0, 0.5, HEIGHT + 0.6)
        run(engine, 0.4)
        picture = engine.render(SKYWARDS)
        _expect_cube("a cube that falls", empty, picture, *engine.body_state("cube").position)

    _unless_blind(rule, built(make))


def pictures_change_nothing(make: Make) -> None:
    """Runs with pictures and without are the same, bit for bit."""

    def states(engine: Engine, look: Callable[[], object]) -> list[BodyState]:
        engine.add_body("cube", body(CUBE), BodyState((0.6, 0.05, 0.5), quaternion(0.3, 0.2, 0.1)))
        drive(engine, 0.3, 0.2)
        found = []
        for _ in range(15):
            run(engine, 0.1)
            look()
            found += [engine.body_state(ROBOT), engine.body_state("cube")]
        return found

    def rule(engine: Engine) -> None:
        def look() -> None:
            engine.link_pose(ROBOT, LIDAR.link)
            engine.render(SKYWARDS)

        seen = states(engine, look)
        unseen = states(built(make, ORIGIN), lambda: None)
        for index, (one, other) in enumerate(zip(seen, unseen, strict=True)):
            when = f"{0.1 * (index // 2 + 1):.1f} s"
            expect(one == other, f"pictures have changed the state at {when}: {one} instead of {other}")

    _unless_blind(rule, built(make, ORIGIN))


def links_are_where_they_are_mounted(make: Make) -> None:
    """Links of a robot are where its base has them, also while it moves, within 1 mm."""
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
