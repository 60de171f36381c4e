"""Rules for engines that move bodies by velocities (`DrivesBodies`), such as people, doors and lifts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sim_nodes.check.bench import CUBE, EDGE, ORIGIN, ROBOT, Make, at, body, built, drive, expect, expect_near, run
from sim_nodes.geometry import Pose2
from sim_nodes.physics import BodyModel, Box, DrivesBodies, Engine, Part, Wall
from sim_nodes.ticks import TICK

LOW = EDGE / 2.0 + 0.01  # [m] height of a cube that does not touch the floor
DRIVEN = replace(body(CUBE), mass=80.0, driven=True)
BUILT_IN = replace(DRIVEN, built_in=True)
PLATFORM = BodyModel((Part(Box((2.0, 2.0, 0.1)), (0.0, 0.0, -0.05)),), mass=1000.0, driven=True, built_in=True)

Row = tuple[float, float, float]


def _move(engine: Engine, seconds: float, velocities: Sequence[Row], heights: Sequence[float]) -> None:
    """Drive the bodies for a duration, in ticks."""
    assert isinstance(engine, DrivesBodies)
    for _ in range(round(seconds / TICK)):
        engine.drive_bodies(np.array(velocities), np.array(heights))
        run(engine, TICK)


def driven_bodies_follow_their_velocities(make: Make) -> None:
    """A driven body moves and turns by its velocities, upright and at its height; it is listed in order."""
    engine = built(make)
    engine.add_body("first", DRIVEN, at(0.0, 0.0, LOW))
    engine.add_body("prop", body(CUBE), at(5.0, 5.0, EDGE / 2.0))
    engine.add_body("second", DRIVEN, at(0.0, 3.0, LOW))
    _move(engine, 2.0, ((0.5, 0.25, 0.4), (-0.5, 0.0, 0.0)), (LOW, LOW))
    assert isinstance(engine, DrivesBodies)
    expect_near("the poses of driven bodies", engine.driven_poses().ravel(), (1.0, 0.5, 0.8, -1.0, 3.0, 0.0), 0.02)
    state = engine.body_state("first")
    expect_near("the height of a driven body [m]", state.position[2], LOW, 0.005)
    expect_near("the tilt of a driven body", state.orientation[1:3], (0.0, 0.0), 1e-3)


def driven_bodies_reach_heights(make: Make) -> None:
    """A driven body is at the given height at the next tick."""
    engine = built(make)
    engine.add_body("lift", BUILT_IN, at(0.0, 0.0, LOW))
    for step in range(1, 51):
        _move(engine, TICK, ((0.0, 0.0, 0.0),), (LOW + step * 0.01,))
    expect_near("the height of a driven body [m]", engine.body_state("lift").position[2], LOW + 0.5, 1e-3)


def driven_bodies_stop_robots(make: Make) -> None:
    """A robot does not push a driven body that stands, and does not enter it."""
    engine = built(make, ORIGIN)
    engine.add_body("post", DRIVEN, at(0.8, 0.1, LOW))
    drive(engine, 0.3, 0.0)
    _move(engine, 4.0, ((0.0, 0.0, 0.0),), (LOW,))
    expect_near("the position of a driven body", engine.body_state("post").position[:2], (0.8, 0.1), 0.03)
    expect(engine.overlaps("post") == (), "the robot is inside of a driven body")


def built_in_bodies_pass_through_walls_and_the_floor(make: Make) -> None:
    """A built-in body has no weight, and passes through walls and the floor without contacts."""
    engine = built(make, walls=(Wall("walls", 1.0, 0.0, 0.0, 0.4, 2.0, 1.0),))
    engine.add_body("door", BUILT_IN, at(0.0, 0.0, 0.0))
    run(engine, 0.5)
    expect_near("the height of a built-in body [m]", engine.body_state("door").position[2], 0.0, 1e-6)
    _move(engine, 2.0, ((0.5, 0.0, 0.0),), (0.0,))
    expect_near("the position of a built-in body", engine.body_state("door").position, (1.0, 0.0, 0.0), 5e-3)
    expect(engine.touching() == frozenset(), "a built-in body touches the wall")
    engine.remove_body("door")
    engine.add_body("cube", body(CUBE), at(3.0, 0.0, EDGE / 2.0))
    run(engine, 0.5)
    fallen = "the height of a cube that was added after a built-in body was removed [m]"
    expect_near(fallen, engine.body_state("cube").position[2], EDGE / 2.0, 0.005)


def built_in_bodies_carry_loads(make: Make) -> None:
    """A built-in platform that climbs carries a cube and a robot."""
    engine = built(make, Pose2(-0.4, 0.0, 0.0))
    engine.add_body("lift", PLATFORM, at(0.0, 0.0, -0.001))
    engine.add_body("cube", body(CUBE), at(0.6, 0.0, EDGE / 2.0 + 0.001))
    run(engine, 0.2)
    for step in range(1, 101):
        _move(engine, TICK, ((0.0, 0.0, 0.0),), (-0.001 + step * 0.004,))
    for name, low in (("cube", EDGE / 2.0), (ROBOT, 0.0)):
        expect_near(f"the height of a lifted {name} [m]", engine.body_state(name).position[2], low + 0.4, 0.01)
