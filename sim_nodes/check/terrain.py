"""Rules for terrain: rays hit it, robots drive on it, and contacts with it are contacts with the floor."""

from __future__ import annotations

import numpy as np

from sim_nodes.check.bench import EXTENT, ROBOT, TURTLEBOT, Make, drive, expect, expect_near, steps
from sim_nodes.geometry import Pose2, roll_pitch_yaw
from sim_nodes.physics import Engine, PlacedRobot, Scene
from sim_nodes.terrain.ground import Ground, HeightField, Slab

SLOPE = 0.08  # rise of the ramp by its length
RISE = 0.16  # [m]
HILLS = np.array([[0, 0, 0, 0, 0], [0, 2, 1, 3, 0], [0, 1, 4, 2, 0], [0, 0, 0, 0, 0]]) * 0.05  # [m]
START = Pose2(-2.4, 0.0, 0.0)
GROUND = Ground(
    slabs=(
        Slab(Pose2(-1.0, 0.0, 0.0), 2.0, 1.0, 0.0, RISE),
        Slab(Pose2(0.5, 0.0, 0.0), 1.0, 1.0, RISE, RISE),
        Slab(Pose2(-1.0, 2.0, 0.6), 1.0, 0.5, 0.3, 0.1),
    ),
    fields=(HeightField(Pose2(1.0, 2.0, 0.4), 2.0, 1.5, 5, 4, HILLS.astype("<f8").tobytes()),),
)


def built_terrain(make: Make) -> Engine:
    """Return an engine with terrain, and a robot before a ramp."""
    engine = make()
    engine.build(Scene((), (PlacedRobot(ROBOT, TURTLEBOT, START),), EXTENT, GROUND))
    return engine


def rays_hit_terrain_at_its_height(make: Make) -> None:
    """Rays from above hit ramps, platforms and height fields at their heights."""
    engine = built_terrain(make)
    base = engine.body_state(ROBOT).position
    for x in np.arange(-2.3, 2.3, 0.23).tolist():
        for y in (0.1, 0.47, 1.6, 1.83, 2.11, 2.4):
            above = (x - base[0], y - base[1], 2.0)
            [distance] = engine.cast_rays(ROBOT, TURTLEBOT.base_link, np.array([[0.0, 0.0, -1.0]]), 5.0, above)
            hit = base[2] + 2.0 - float(distance)
            expect_near(f"the height at ({x:g}, {y:g})", hit, GROUND.height(x, y), 5e-3)


def robots_drive_over_terrain(make: Make) -> None:
    """A robot drives up a ramp, tilts with it, and touches nothing; batches equal single steps."""
    singly, at_once = built_terrain(make), built_terrain(make)
    drive(singly, 0.3, 0.0)
    drive(at_once, 0.3, 0.0)
    half = round(4.3 * singly.steps_per_second)
    for reached in ("ramp", "platform"):
        for _ in range(half):
            singly.step()
        steps(at_once, half)
        state, other = singly.body_state(ROBOT), at_once.body_state(ROBOT)
        expect(state == other, f"after a batch the robot is at {other} instead of {state}")
        x, y, z = state.position
        expect_near(f"the height of the robot on the {reached}", z, GROUND.height(x, y), 0.01)
        pitch = roll_pitch_yaw(state.orientation)[1]
        expect_near(f"its pitch on the {reached}", pitch, -SLOPE if reached == "ramp" else 0.0, 0.02)
        expect(not singly.touching() and not singly.contact_points(ROBOT), "the robot touches something")
