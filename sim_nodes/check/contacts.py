"""Rules for contacts and overlaps."""

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
FRONT = 0.164  # [m] distance of the front of a robot from its origin


def pairs_within(engine: Engine, seconds: float) -> set[tuple[str, str]]:
    """Return all pairs in contact during a duration [s]."""
    pairs: set[tuple[str, str]] = set()
    for _ in range(round(seconds * engine.steps_per_second)):
        engine.step()
        pairs |= engine.touching()
    return pairs


def contacts_name_both_bodies(make: Make) -> None:
    """Two bodies in contact are one pair, sorted by name; the floor is not reported."""
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
    """A robot that drives against a wall, a body or a robot touches it, from its arrival on."""
    engine = built(make, ORIGIN, walls=(WALL,))
    drive(engine, 0.3, 0.0)
    found = pairs_within(engine, 2.0)
    expect(not found, f"before the wall a robot touches {found}")
    found = pairs_within(engine, 2.0)
    expect(found == {("barrier", ROBOT)}, f"a robot at a wall gives the contacts {found or 'none'}")
    engine = built(make, ORIGIN, Pose2(0.5, 0.0, 0.0))
    engine.add_body("box", body(CUBE, static=True), at(-0.4, 0.0, EDGE / 2))
    drive(engine, 0.3, 0.0)
    found = pairs_within(engine, 1.5)
    expect(found == {(ROBOT, OTHER)}, f"a robot that pushes another gives the contacts {found or 'none'}")
    drive(engine, -0.3, 0.0)
    found = pairs_within(engine, 3.0)
    expect(("box", ROBOT) in found, f"a robot that backs into a box gives the contacts {found or 'none'}")


def contact_points_are_between_the_entities(make: Make) -> None:
    """Contact points lie between the two entities and name the other one, and exist only in contact."""
    engine = built(make, ORIGIN, Pose2(-0.45, 0.0, 0.0), walls=(WALL,))
    run(engine, 0.5)
    found = engine.contact_points(ROBOT)
    expect(not found, f"a robot that touches nothing has the points {found}")
    drive(engine, 0.3, 0.0)
    drive(engine, 0.3, 0.0, OTHER)
    run(engine, 4.0)
    for robot, others in ((ROBOT, {"barrier", OTHER}), (OTHER, {ROBOT})):
        points = engine.contact_points(robot)
        named = {point.entity for point in points}
        expect(named == others, f"the points of {robot} are those of {named or 'none'} instead of {others}")
        x, y, _ = engine.body_state(robot).position
        for point in points:
            ahead = point.position[0] - x
            wanted = FRONT if point.entity in ("barrier", ROBOT) else -FRONT
            expect_near(f"the point of {robot} and {point.entity} ahead of {robot} [m]", ahead, wanted, 0.02)
            expect_near(f"the point of {robot} and {point.entity} beside it [m]", point.position[1], y, 0.05)
            towards = 1.0 if wanted > 0.0 else -1.0
            expect_near(f"the normal of {robot} and {point.entity}, ahead", point.normal[0], towards, 0.1)
            height = point.position[2]
            expect(0.0 < height < 0.36, f"the point of {robot} and {point.entity} is {height:.3f} m high")


def near_bodies_do_not_touch(make: Make) -> None:
    """Bodies 5 mm apart neither touch nor overlap."""
    for name, shape in SHAPES.items():
        engine = built(make, ORIGIN, walls=(WALL,))
        engine.add_body("first", body(shape), at(0.9 - EDGE / 2 - 0.005, 0.0, EDGE / 2))
        engine.add_body("second", body(shape), at(0.9 - 1.5 * EDGE - 0.01, 0.0, EDGE / 2))
        run(engine, 0.1)
        touching, overlaps = engine.touching(), engine.overlaps("first")
        expect(not touching, f"a {name} that is 5 mm from others touches {set(touching)}")
        expect(not overlaps, f"a {name} that is 5 mm from others overlaps {overlaps}")


def overlaps_are_found_for_every_shape(make: Make) -> None:
    """Overlaps with robots, walls, and static or dynamic bodies are found immediately, sorted."""
    for name, shape in SHAPES.items():
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


def resting_bodies_do_not_overlap(make: Make) -> None:
    """Contact at rest and touching faces are not overlaps."""
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
