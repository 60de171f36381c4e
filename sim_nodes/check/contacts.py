"""Rules about what touches and what overlaps."""

from __future__ import annotations

from sim_nodes.check.bench import (
    CUBE,
    EDGE,
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
from sim_nodes.geometry import Pose2
from sim_nodes.physics import Engine, Wall

WALL = Wall("barrier", 1.0, 0.0, 0.0, 0.2, 2.0, 0.5)
REACHED = 0.164  # [m] ahead of a robot's origin


def touches(engine: Engine, seconds: float) -> set[tuple[str, str]]:
    """All pairs that touch in some step of a time."""
    pairs: set[tuple[str, str]] = set()
    for _ in range(round(seconds * engine.steps_per_second)):
        engine.step()
        pairs |= engine.touching()
    return pairs


def contacts_name_both(make: Make) -> None:
    """Two bodies in contact are one pair, names in order; the floor is left out."""
    engine = built(make, ORIGIN)
    engine.add_body("lower", body(CUBE), at(1.0, 1.0, EDGE / 2))
    engine.add_body("a_upper", body(CUBE), at(1.0, 1.0, EDGE * 1.5))
    run(engine, 0.5)
    found = engine.touching()
    expect(found == {("a_upper", "lower")}, f"a box on a box gives the contacts {set(found) or 'none'}")
    engine.remove_body("a_upper")
    engine.step()
    expect(not engine.touching(), f"a box and a robot on the floor give the contacts {set(engine.touching())}")


def robots_touch_walls_and_each_other(make: Make) -> None:
    """A robot that drives against a wall, a body or a robot touches it, from when it is there."""
    engine = built(make, ORIGIN, walls=(WALL,))
    drive(engine, 0.3, 0.0)
    found = touches(engine, 2.0)
    expect(not found, f"on its way to the wall a robot touches {found}")
    found = touches(engine, 2.0)
    expect(found == {("barrier", ROBOT)}, f"a robot at a wall gives the contacts {found or 'none'}")
    engine = built(make, ORIGIN, Pose2(0.5, 0.0, 0.0))
    engine.add_body("box", body(CUBE, static=True), at(-0.4, 0.0, EDGE / 2))
    drive(engine, 0.3, 0.0)
    found = touches(engine, 1.5)
    expect(found == {(ROBOT, OTHER)}, f"a robot that pushes another gives the contacts {found or 'none'}")
    drive(engine, -0.3, 0.0)
    found = touches(engine, 3.0)
    expect(("box", ROBOT) in found, f"a robot that backs into a box gives the contacts {found or 'none'}")


def robots_touch_where_they_are(make: Make) -> None:
    """Points in which a robot touches others lie between the two and name the other; else there are none."""
    engine = built(make, ORIGIN, Pose2(-0.45, 0.0, 0.0), walls=(WALL,))
    run(engine, 0.5)
    found = engine.touch_points(ROBOT)
    expect(not found, f"a robot that touches nothing has the points {found}")
    drive(engine, 0.3, 0.0)
    drive(engine, 0.3, 0.0, OTHER)
    run(engine, 4.0)
    for robot, others in ((ROBOT, {"barrier", OTHER}), (OTHER, {ROBOT})):
        points = engine.touch_points(robot)
        named = {point.entity for point in points}
        expect(named == others, f"the points of {robot} are those of {named or 'none'} instead of {others}")
        x, y, _ = engine.body_state(robot).position
        for point in points:
            ahead = point.position[0] - x
            wanted = REACHED if point.entity in ("barrier", ROBOT) else -REACHED
            expect_near(f"the point of {robot} and {point.entity} ahead of {robot} [m]", ahead, wanted, 0.02)
            expect_near(f"the point of {robot} and {point.entity} beside it [m]", point.position[1], y, 0.05)
            towards = 1.0 if wanted > 0.0 else -1.0
            expect_near(f"the normal of {robot} and {point.entity}, ahead", point.normal[0], towards, 0.1)
            height = point.position[2]
            expect(0.0 < height < 0.36, f"the point of {robot} and {point.entity} is {height:.3f} m high")


def what_is_near_does_not_touch(make: Make) -> None:
    """What is 5 mm apart does not touch and does not overlap."""
    for shape in SHAPES:
        engine = built(make, ORIGIN, walls=(WALL,))
        engine.add_body("first", body(shape), at(0.9 - EDGE / 2 - 0.005, 0.0, EDGE / 2))
        engine.add_body("second", body(shape), at(0.9 - 1.5 * EDGE - 0.01, 0.0, EDGE / 2))
        run(engine, 0.1)
        name = type(shape).__name__.lower()
        touching, overlaps = engine.touching(), engine.overlaps("first")
        expect(not touching, f"a {name} that is 5 mm from others touches {set(touching)}")
        expect(not overlaps, f"a {name} that is 5 mm from others overlaps {overlaps}")


def overlaps_are_found_for_every_shape(make: Make) -> None:
    """Overlaps with robots, walls and bodies are found at once, sorted, whether static or not."""
    for shape in SHAPES:
        name = type(shape).__name__.lower()
        for static in (False, True):
            engine = built(make, ORIGIN, walls=(WALL,))
            engine.add_body("body", body(shape, static=static), at(0.1, 0.0, 0.15))
            _expect_overlaps(engine, f"a {name} in a robot", (ROBOT,))
            engine.set_body_state("body", at(0.5, 0.0, 0.15))
            _expect_overlaps(engine, f"a {name} in the open", ())
            engine.set_body_state("body", at(0.9, 0.0, 0.15))
            _expect_overlaps(engine, f"a {name} in a wall", ("barrier",))
            engine.add_body("another", body(CUBE, static=static), at(0.8, 0.0, 0.15))
            _expect_overlaps(engine, f"a {name} in a wall and a box", ("another", "barrier"))
            engine.set_body_state("body", at(3.0, 0.0, 0.01))
            _expect_overlaps(engine, f"a {name} in the floor", ())


def what_rests_on_something_does_not_overlap_it(make: Make) -> None:
    """Contact at rest, and a gap of nothing, are no overlap."""
    engine = built(make)
    engine.add_body("lower", body(CUBE), at(1.0, 1.0, EDGE / 2))
    engine.add_body("upper", body(CUBE), at(1.0, 1.0, EDGE * 1.5))
    engine.add_body("beside", body(CUBE), at(1.0 + EDGE, 1.0, EDGE / 2))
    _expect_overlaps(engine, "a box between a box above and one beside it", (), "lower")
    run(engine, 1.0)
    _expect_overlaps(engine, "the same after a second", (), "lower")


def _expect_overlaps(engine: Engine, what: str, wanted: tuple[str, ...], name: str = "body") -> None:
    found = engine.overlaps(name)
    expect(found == wanted, f"the overlaps of {what} are {found} instead of {wanted}")
