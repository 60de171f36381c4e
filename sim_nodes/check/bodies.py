"""Rules for added bodies: states, falling, resting, sliding, carrying loads, contacts, and overlaps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sim_nodes.check.bench import (
    CUBE,
    EDGE,
    GRAVITY,
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
    expect_state,
    run,
)
from sim_nodes.geometry import Pose2, quaternion, rotation_matrix
from sim_nodes.inertia import inertia
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Engine, Part, Sphere, Wall

ROUNDING = 1e-9
LOPSIDED = BodyModel(
    (
        Part(Box((0.4, 0.1, 0.1)), (0.2, 0.1, 0.05)),
        Part(Sphere(0.1), (0.0, 0.0, 0.3)),
        Part(Cylinder(0.05, 0.3), (0.3, -0.1, 0.2), quaternion(0.4, math.pi / 2, 0.2)),
    ),
    mass=3.0,
)
MOVING = BodyState((2.0, -1.0, 1.5), quaternion(0.3, 0.2, 0.1), (0.1, 0.2, 0.3), (1.0, 2.0, 3.0))


def states_are_returned_as_set(make: Make) -> None:
    """The state in which a body is added or set is returned, for the origin of its own frame."""
    engine = built(make, ORIGIN)
    for name, model in (("cube", body(CUBE)), ("lopsided", LOPSIDED)):
        engine.add_body(name, model, at(3.0, 3.0, 1.0))
        expect_state(f"an added {name}", engine.body_state(name), at(3.0, 3.0, 1.0), ROUNDING)
        engine.set_body_state(name, MOVING)
        expect_state(f"a {name} that was moved", engine.body_state(name), MOVING, ROUNDING)
        engine.remove_body(name)
        engine.add_body(name, model, MOVING)
        expect_state(f"a {name} that was added moving", engine.body_state(name), MOVING, ROUNDING)
        engine.reset()
        expect_state(f"a {name} that was added moving, after a reset", engine.body_state(name), MOVING, ROUNDING)
        engine.remove_body(name)


def bodies_fall_with_gravity(make: Make) -> None:
    """A body of any shape falls by g t^2 / 2 and keeps its horizontal velocity."""
    engine = built(make)
    models = {name: body(shape) for name, shape in SHAPES.items()} | {"lopsided": LOPSIDED}
    for index, (name, model) in enumerate(models.items()):
        engine.add_body(name, model, at(0.0, 2.0 * index, 9.0))
        engine.set_body_state(name, BodyState((0.0, 2.0 * index, 9.0), linear=(1.0, 0.0, 0.0)))
    for time in (0.2, 1.0):
        run(engine, time if time < 0.5 else 0.8)
        for name in models:
            state = engine.body_state(name)
            # First-order integration is off by half the fall of one step.
            tolerance = GRAVITY * time / engine.steps_per_second
            fallen = 9.0 - state.position[2]
            expect_near(f"the fall of {name} in {time} s [m]", fallen, GRAVITY * time**2 / 2, tolerance)
            expect_near(f"the velocity of {name} after {time} s", state.linear, (1.0, 0.0, -GRAVITY * time), 1e-6)
            expect_near(f"the horizontal distance of {name} in {time} s [m]", state.position[0], time, 1e-6)


def bodies_keep_high_velocities(make: Make) -> None:
    """A body at 300 m/s that spins at 200 rad/s keeps both velocities."""
    engine = built(make)
    engine.add_body("shot", body(Sphere(0.1)), at(0.0, 0.0, 5.0))
    engine.set_body_state("shot", BodyState((0.0, 0.0, 5.0), linear=(300.0, 0.0, 0.0), angular=(0.0, 0.0, 200.0)))
    run(engine, 0.5)
    found = engine.body_state("shot")
    expect_near("the distance of a shot in 0.5 s [m]", found.position[0], 150.0, 1e-3)
    expect_near("the rate of turning of a shot [rad/s]", found.angular[2], 200.0, 1e-3)


def bodies_turn_about_their_centre_of_mass(make: Make) -> None:
    """A body in the air turns about its centre of mass, and its velocity is that of its origin."""
    even = BodyModel((Part(CUBE, (0.3, 0.0, 0.0)), Part(CUBE, (0.1, 0.0, 0.0))), mass=2.0)
    head, grip = (replace(part, mass=mass) for part, mass in zip(even.parts, (1.9, 0.1), strict=True))
    for what, model in (("club", even), ("club that is heavy at its end", replace(even, parts=(head, grip)))):
        _turn(built(make), what, model)


def _turn(engine: Engine, what: str, model: BodyModel) -> None:
    rate, time = 2.0, 0.5
    centre = np.array(inertia(model).centre)
    engine.add_body("club", model, at(0.0, 0.0, 9.0))
    engine.set_body_state("club", BodyState((0.0, 0.0, 9.0), angular=(0.0, 0.0, rate)))
    run(engine, time)
    state = engine.body_state("club")
    turn = rotation_matrix(quaternion(0.0, 0.0, rate * time))
    origin = centre + np.cross((0.0, 0.0, rate), centre) * time - turn @ centre
    expect_near(f"the angle turned by a {what} [rad]", state.planar.yaw, rate * time, 0.01)
    expect_near(f"the position of the origin of a turning {what}", state.position[:2], origin[:2], 0.01)
    before = np.array(state.position)
    engine.step()
    after = np.array(engine.body_state("club").position)
    moved = (after - before) * engine.steps_per_second
    expect_near(f"the velocity of the origin of a turning {what}", state.linear[:2], moved[:2], 0.02)


def bodies_on_the_floor_stay_at_rest(make: Make) -> None:
    """A body that is placed on the floor stays at rest."""
    engine = built(make)
    for index, (name, shape) in enumerate(SHAPES.items()):
        engine.add_body(name, body(shape), at(float(index), 0.0, EDGE / 2))
    run(engine, 2.0)
    for index, name in enumerate(SHAPES):
        found = engine.body_state(name)
        expect_near(f"the position of a {name} after 2 s", found.position, (float(index), 0.0, EDGE / 2), 2e-3)
        expect_near(f"the velocity of a {name} after 2 s", found.linear, (0.0, 0.0, 0.0), 2e-3)


def friction_stops_sliding_bodies(make: Make) -> None:
    """On the floor, whose friction is 1, a box of friction 1 slides by v^2 / 2 g; with less friction, no less."""
    speed = 2.0
    expected = speed**2 / (2 * GRAVITY)
    for friction, furthest in ((1.0, 1.2 * expected), (0.5, 2.4 * expected)):
        engine = built(make)
        flat = body(Box((0.4, 0.4, 0.05)), friction=friction)
        engine.add_body("box", flat, at(0.0, 0.0, 0.025))
        run(engine, 0.5)
        engine.set_body_state("box", BodyState(engine.body_state("box").position, linear=(speed, 0.0, 0.0)))
        run(engine, 2.0)
        slid = engine.body_state("box").position[0]
        expect(
            0.8 * expected <= slid <= furthest,
            f"a box of friction {friction} with {speed} m/s slid {slid:.3f} m instead of {0.8 * expected:.3f} "
            f"to {furthest:.3f} m",
        )


def static_bodies_support_loads(make: Make) -> None:
    """A static body stays where it is placed, also in the air, and supports loads."""
    engine = built(make, ORIGIN)
    engine.add_body("table", body(CUBE, static=True), at(0.0, 2.0, 1.0))
    engine.add_body("load", body(CUBE), at(0.0, 2.0, 1.0 + 1.1 * EDGE))
    engine.add_body("wall", body(CUBE, static=True), at(0.5, 0.0, EDGE / 2))
    drive(engine, 0.3, 0.0, seconds=2.0)
    expect_state("a loaded static body", engine.body_state("table"), at(0.0, 2.0, 1.0), ROUNDING)
    expect_near("the position of its load", engine.body_state("load").position, (0.0, 2.0, 1.0 + EDGE), 5e-3)
    expect_state("a static body that a robot pushes", engine.body_state("wall"), at(0.5, 0.0, EDGE / 2), ROUNDING)
    engine.set_body_state("table", at(3.0, 3.0, 2.0))
    expect_state("a static body that was moved", engine.body_state("table"), at(3.0, 3.0, 2.0), ROUNDING)
    run(engine, 1.0)
    fallen = engine.body_state("load").position[2]
    expect_near("the height of a load whose table was moved away", fallen, EDGE / 2, 5e-3)


def adding_and_removing_changes_nothing_else(make: Make) -> None:
    """Adding or removing a body leaves all other states bit-identical."""
    engine = built(make, ORIGIN)
    engine.add_body("old", LOPSIDED, MOVING)
    engine.add_body("table", body(CUBE, static=True), at(0.0, 3.0, 1.0))
    drive(engine, 0.3, 0.5, seconds=0.3)

    before = _states(engine)
    for static in (False, True):
        engine.add_body("new", body(CUBE, static=static), at(-3.0, 0.0, 1.0))
        _expect_unchanged(engine, "adding", before)
        engine.remove_body("new")
        _expect_unchanged(engine, "removing", before)
    engine.remove_body("old")
    drive(engine, 0.3, 0.0)
    travelled = engine.wheel_angles(ROBOT)[0]
    run(engine, 1.0)
    expect(engine.wheel_angles(ROBOT)[0] > travelled + 5.0, "after removing a body a robot no longer drives")


def _states(engine: Engine) -> dict[str, object]:
    states = {name: engine.body_state(name) for name in (ROBOT, "old", "table")}
    return {**states, "the wheels": engine.wheel_angles(ROBOT)}


def _expect_unchanged(engine: Engine, what: str, before: dict[str, object]) -> None:
    for name, state in _states(engine).items():
        expect(state == before[name], f"{what} another body changed {name} from {before[name]} to {state}")


def bodies_may_have_many_parts(make: Make) -> None:
    """A body of 64 parts is solid in all of them."""
    engine, edge = built(make), 0.1
    grid = [(x * edge, y * edge) for x in range(8) for y in range(8)]
    parts = tuple(Part(Box((edge, edge, edge)), (x, y, 0.0)) for x, y in grid)
    engine.add_body("slab", BodyModel(parts, mass=10.0, static=True), at(0.0, 0.0, 1.0))
    for index, (x, y) in enumerate(grid):
        engine.add_body(f"ball{index}", body(Sphere(0.02)), at(x, y, 1.0 + edge / 2 + 0.02))
    run(engine, 0.2)
    for index, (x, y) in enumerate(grid):
        found = engine.body_state(f"ball{index}").position
        expect_near(f"the position of a ball on part {index}", found, (x, y, 1.0 + edge / 2 + 0.02), 5e-3)


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
    drive(engine, 0.3, 0.0, OTHER, seconds=4.0)
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
