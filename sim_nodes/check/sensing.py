"""Rules for lidar rays, for rendering, and for the poses of links.

Engines that do not render here (`NoRendering`) pass.
"""

from __future__ import annotations

import itertools
import math
from contextlib import suppress

import numpy as np

from sim_nodes.check.bench import (
    CUBE,
    EDGE,
    LIDAR,
    ORIGIN,
    OTHER,
    ROBOT,
    SHAPES,
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
from sim_nodes.physics import BodyState, Engine, Wall
from sim_nodes.views import Lens, NoRendering, Picture, View

EXACT = 0.01  # [m]
LIMIT = LIDAR.max_range
ANGLES = np.linspace(-math.pi, math.pi, 360, endpoint=False)  # around the lidar [rad]
DIRECTIONS = np.column_stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros_like(ANGLES)])
MOUNT = Pose2(LIDAR.x, LIDAR.y, LIDAR.yaw)
HALF_LENGTH, HALF_WIDTH = 2.0, 1.0  # of the room [m]
ROOM = (
    Wall("walls", HALF_LENGTH + 0.05, 0.0, 0.0, 0.1, 2.4, 0.5),
    Wall("walls", -HALF_LENGTH - 0.05, 0.0, math.pi / 2, 2.4, 0.1, 0.5),
    Wall("walls", 0.0, HALF_WIDTH + 0.05, 0.0, 4.4, 0.1, 0.5),
    Wall("back", 0.0, -HALF_WIDTH - 0.05, math.pi, 4.4, 0.1, 0.5),
)


def range_to(engine: Engine, x: float, y: float, limit: float = LIMIT) -> float:
    """Return the range of the robot's lidar in the direction of a point of the world [m]."""
    lidar = engine.body_state(ROBOT).planar.compose(MOUNT)
    angle = math.atan2(y - lidar.y, x - lidar.x) - lidar.yaw
    [distance] = engine.cast_rays(
        ROBOT, LIDAR.link, np.array([[math.cos(angle), math.sin(angle), 0.0]]), limit
    ).tolist()
    return float(distance)


def room_ranges(lidar: Pose2) -> Array:
    """Return the distances to the walls of the room [m]."""
    cos, sin = np.cos(ANGLES + lidar.yaw), np.sin(ANGLES + lidar.yaw)
    with np.errstate(divide="ignore"):
        to_x = np.where(cos > 0, HALF_LENGTH - lidar.x, HALF_LENGTH + lidar.x) / np.abs(cos)
        to_y = np.where(sin > 0, HALF_WIDTH - lidar.y, HALF_WIDTH + lidar.y) / np.abs(sin)
    nearest: Array = np.minimum(to_x, to_y)
    return nearest


def rays_end_at_walls(make: Make) -> None:
    """Rays are as long as the distance to the walls, within 1 cm, and infinite beyond the limit."""
    for pose in (ORIGIN, Pose2(0.7, -0.4, 2.0), Pose2(-1.5, 0.6, -1.0)):
        engine = built(make, pose, walls=ROOM)
        run(engine, 0.5)
        wanted = room_ranges(engine.body_state(ROBOT).planar.compose(MOUNT))
        found = engine.cast_rays(ROBOT, LIDAR.link, DIRECTIONS, LIMIT)
        expect(found.shape == (360,), f"360 rays gave an array of shape {found.shape} instead of (360,)")
        for angle, distance, expected in zip(ANGLES, found, wanted, strict=True):
            expect_near(f"the ray at {angle:.3f} rad from {pose} [m]", float(distance), float(expected), EXACT)
        short = engine.cast_rays(ROBOT, LIDAR.link, DIRECTIONS, 1.0)
        wrong = np.flatnonzero(
            np.isinf(short) & (wanted < 1.0 - EXACT) | ~np.isinf(short) & (wanted > 1.0 + EXACT)
        )
        expect(not len(wrong), f"with a limit of 1 m, {len(wrong)} of 360 rays end beyond it, or do not before it")


def rays_start_at_the_present_pose(make: Make) -> None:
    """Rays start at the present pose of a moving robot, not at that of the step before."""
    engine = built(make, ORIGIN, walls=ROOM)
    drive(engine, 0.1, 1.8)
    for _ in range(5):
        run(engine, 0.2)
        wanted = room_ranges(engine.body_state(ROBOT).planar.compose(MOUNT))
        found = engine.cast_rays(ROBOT, LIDAR.link, DIRECTIONS, LIMIT)
        expect_near("the greatest error of a ray of a turning robot [m]", np.abs(found - wanted).max(), 0.0, EXACT)


def rays_end_at_every_shape(make: Make) -> None:
    """Rays end at boxes, cylinders and spheres, static or not, within 1 cm."""
    engine = built(make, ORIGIN)
    run(engine, 0.5)
    lidar_height = 0.193
    for name, shape in SHAPES.items():
        for static in (False, True):
            engine.add_body("body", body(shape, static=static), at(MOUNT.x, 1.0, lidar_height))
            expect_near(f"the ray to a {name} [m]", range_to(engine, MOUNT.x, 1.0), 1.0 - EDGE / 2, EXACT)
            beside = range_to(engine, MOUNT.x + 0.75 * EDGE, 1.0)
            expect(math.isinf(beside), f"a ray that passes a {name} by 5 cm ends at {beside:.3f} m")
            engine.remove_body("body")
    engine.add_body("low", body(CUBE), at(MOUNT.x, 1.0, EDGE / 2 - 0.05))
    engine.set_body_state("low", BodyState((MOUNT.x, 1.0, -1.0)))
    expect(math.isinf(range_to(engine, MOUNT.x, 1.0)), "a ray ends at a body that is below it")


def robots_do_not_see_themselves(make: Make) -> None:
    """No ray ends at the robot that casts it, in any pose and motion."""
    engine = built(make, ORIGIN)
    limit = 3.0  # [m]; farther out, a robot that tilts slightly sees the floor
    drive(engine, 0.2, 1.5)
    for step in range(11):
        run(engine, 0.1)
        if step == 10:
            engine.set_body_state(ROBOT, BodyState((3.0, 3.0, 0.0), quaternion(0.0, 0.0, 1.0)))
        ranges = engine.cast_rays(ROBOT, LIDAR.link, DIRECTIONS, limit)
        seen = ranges[np.isfinite(ranges)]
        if len(seen):
            raise AssertionError(
                f"in an empty world {len(seen)} of 360 rays end, the nearest at {seen.min():.3f} m"
            )


def robots_see_each_other(make: Make) -> None:
    """Robots see each other."""
    engine = built(make, ORIGIN, Pose2(2.0, 0.0, 0.0))
    run(engine, 0.5)
    tower = 0.145  # [m], radius of the collision shape at the lidar's height
    expect_near("the ray from one robot to another [m]", range_to(engine, 2.0, 0.0), 2.0 - MOUNT.x - tower, EXACT)
    back = engine.cast_rays(OTHER, LIDAR.link, DIRECTIONS, LIMIT)
    expect(bool(np.isfinite(back).any()), "the second robot does not see the first")


def rays_see_changes_before_the_next_step(make: Make) -> None:
    """Rays reflect added, set and removed bodies immediately, without a step."""
    engine = built(make, ORIGIN)
    for static in (False, True):
        engine.add_body("body", body(CUBE, static=static), at(1.0, 0.0, 0.2))
        expect_near("the ray to a new body [m]", range_to(engine, 1.0, 0.0), 1.0 - EDGE / 2 - MOUNT.x, EXACT)
        engine.set_body_state("body", at(2.0, 0.0, 0.2))
        expect_near("the ray to a moved body [m]", range_to(engine, 2.0, 0.0), 2.0 - EDGE / 2 - MOUNT.x, EXACT)
        engine.set_body_state("body", at(-5.0, 3.0, 0.2))
        expect(math.isinf(range_to(engine, 2.0, 0.0)), "a ray ends where a body was before it was moved")
        engine.remove_body("body")
        expect(math.isinf(range_to(engine, -5.0, 3.0)), "a ray ends at a body that was removed")


LENS = Lens(math.radians(40.0), 320, 240)
HEIGHT = 10.0  # [m] of a camera that sees only the sky
SKYWARDS = View((-3.0, 0.0, HEIGHT), quaternion(0.0, 0.0, 0.0), LENS)
CLOSE = 1.2  # [pixels]
VISIBLE = 8  # of 255; minimum change of a pixel


def _expect_cube(what: str, before: Picture, after: Picture, x: float, y: float, z: float) -> None:
    """Expect a cube in one of two images where a pinhole camera projects its corners."""
    rows, columns = np.nonzero(np.abs(before.astype(int) - after.astype(int)).max(axis=2) > VISIBLE)
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
        wanted = engine.body_state(ROBOT).planar.compose(MOUNT)
        (x, y, _), orientation = engine.link_pose(ROBOT, LIDAR.link)
        expect_near("x and y of the lidar's link [m]", (x, y), (wanted.x, wanted.y), 2e-3)
        turn = math.remainder(yaw_of(orientation) - wanted.yaw, 2 * math.pi)
        expect_near("the yaw of the lidar's link off its mount [rad]", turn, 0.0, 1e-2)
