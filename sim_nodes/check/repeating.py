"""Rules for time, resets and reproducibility."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sim_nodes.check.bench import (
    CUBE,
    EDGE,
    LIDAR,
    ORIGIN,
    OTHER,
    ROBOT,
    Make,
    at,
    body,
    built,
    drive,
    expect,
    expect_near,
    expect_same,
    expect_state,
    run,
    scene,
    steps,
)
from sim_nodes.check.bodies import LOPSIDED, MOVING
from sim_nodes.check.sensing import DIRECTIONS, LIMIT, ROOM
from sim_nodes.geometry import Pose2
from sim_nodes.physics import BodyState, Engine, Sphere, UnstablePhysics
from sim_nodes.ticks import TICK

SECOND = Pose2(1.0, 0.2, 3.0)
HUGE = (1e300, 1e300, 1e300)


def steps_fit_into_ticks(make: Make) -> None:
    """An engine has a name, a version, and a whole number of steps in a tick of 20 ms."""
    engine = make()
    for what, found in (("name", engine.name), ("version", engine.version)):
        expect(isinstance(found, str) and bool(found), f"the {what} is {found!r} instead of a text")
    steps = engine.steps_per_second * TICK
    expect_near("the number of steps in a tick", steps, max(1.0, round(steps)), 1e-9)


def observe(engine: Engine, names: Sequence[str] = ()) -> list[object]:
    """Return the observations of two robots and the named bodies."""
    seen: list[object] = [engine.body_state(name) for name in (ROBOT, OTHER, *names)]
    seen += [engine.wheel_angles(ROBOT), engine.wheel_angles(OTHER), sorted(engine.touching())]
    seen += [engine.overlaps(name) for name in (ROBOT, *names)]
    seen.append(engine.cast_rays(ROBOT, LIDAR.link, DIRECTIONS, LIMIT).tobytes())
    return seen


def observe_run(engine: Engine, names: Sequence[str] = ()) -> list[object]:
    """Return the observations of the next 0.6 s."""
    seen = []
    for _ in range(4):
        run(engine, 0.15)
        seen += observe(engine, names)
    return seen


def observe_changes(engine: Engine) -> list[object]:
    """Return the observations of a run with driving robots and changing bodies, in a room with two robots."""
    drive(engine, 0.3, 0.4)
    drive(engine, 0.2, -0.3, OTHER)
    seen = observe_run(engine)
    engine.add_body("box", body(CUBE), at(0.5, 0.1, EDGE / 2))
    engine.add_body("thing", LOPSIDED, MOVING)
    seen += observe_run(engine, ("box", "thing"))
    engine.remove_body("thing")
    engine.set_body_state(OTHER, BodyState((-0.5, 0.0, 0.0)))
    engine.add_body("thing", body(CUBE, static=True), at(0.8, -0.5, EDGE / 2))
    return seen + observe_run(engine, ("box", "thing"))


def batches_equal_single_steps(make: Make) -> None:
    """A batch of steps gives states that are bit-identical to those of single steps."""
    singly, at_once = (built(make, ORIGIN, SECOND, walls=ROOM) for _ in range(2))
    for engine in (singly, at_once):
        engine.add_body("box", body(CUBE), at(0.5, 0.1, EDGE / 2))
        engine.add_body("thing", LOPSIDED, MOVING)
        drive(engine, 0.3, 0.4)
        drive(engine, 0.2, -0.3, OTHER)
    for count in (1, 2, 3, 5, 17, 100, 3, 150, 1, 40):
        for _ in range(count):
            singly.step()
        steps(at_once, count)
        for name in (ROBOT, OTHER, "box", "thing"):
            one, other = singly.body_state(name), at_once.body_state(name)
            expect(one == other, f"after {count} steps at once {name} is at {other} instead of {one}")
        expect(
            singly.touching() == at_once.touching(), f"after {count} steps at once {set(at_once.touching())} touch"
        )


def batches_end_where_contacts_change(make: Make) -> None:
    """A batch ends after the step in which the pairs in contact change, and returns the number of steps."""
    singly, at_once = (built(make, ORIGIN) for _ in range(2))
    for engine in (singly, at_once):
        engine.add_body("table", body(CUBE, static=True), at(2.0, 0.0, EDGE / 2))
        engine.add_body("ball", body(Sphere(EDGE / 2)), at(2.0, 0.0, 2.0))  # it may bounce, and rolls off
        engine.set_body_state("ball", BodyState((2.0, 0.0, 2.0), linear=(0.05, 0.0, 0.0)))
        drive(engine, 0.3, 0.0)
    made, wanted, limit = 0, 0, 2 * engine.steps_per_second
    touching: frozenset[tuple[str, str]] = frozenset()
    while made < limit:
        made += at_once.step(limit - made)
        while wanted < limit and singly.touching() == touching:
            singly.step()
            wanted += 1
        expect(
            made == wanted, f"a call of `step` ends after step {made} instead of {wanted}, the first with a change"
        )
        touching = singly.touching()
        expect(
            at_once.touching() == touching, f"after it {set(at_once.touching())} touch instead of {set(touching)}"
        )


def equal_runs_are_bit_identical(make: Make) -> None:
    """Two engines with the same scene and commands give bit-identical results."""
    first, second = (observe_changes(built(make, ORIGIN, SECOND, walls=ROOM)) for _ in range(2))
    expect_same("a second engine", first, second)


def building_replaces_everything(make: Make) -> None:
    """Building a scene in a used engine is the same as in a new one."""
    engine = built(make, ORIGIN, SECOND, walls=ROOM)
    first = observe_changes(engine)
    engine.build(scene(ORIGIN))
    run(engine, 0.5)
    place = engine.body_state(ROBOT).position
    expect_near("the position of a robot with commands of an earlier scene", place, (0.0, 0.0, 0.0), 2e-3)
    engine.build(scene(ORIGIN, SECOND, walls=ROOM))
    expect_same("an engine that was used before", first, observe_changes(engine))


def a_reset_restores_everything(make: Make) -> None:
    """A reset returns robots and bodies to their initial states, at rest, without commands."""
    engine = built(make, SECOND)
    start = engine.body_state(ROBOT)
    engine.add_body("box", body(CUBE), at(3.0, 1.0, 1.0))
    engine.add_body("table", body(CUBE, static=True), at(3.0, 3.0, 1.0))
    engine.add_body("gone", body(CUBE), at(-3.0, 3.0, 1.0))
    drive(engine, 0.3, 0.2, seconds=1.0)
    engine.set_body_state("table", at(-3.0, -3.0, 1.0))
    engine.remove_body("gone")
    engine.reset()
    expect_state("a robot", engine.body_state(ROBOT), start, 1e-12)
    expect_near("the angles of its wheels [rad]", engine.wheel_angles(ROBOT), (0.0, 0.0), 0.0)
    expect_state("a box", engine.body_state("box"), at(3.0, 1.0, 1.0), 1e-12)
    expect_state("a static body", engine.body_state("table"), at(3.0, 3.0, 1.0), 1e-12)
    expect(not engine.touching(), f"after a reset there are the contacts {set(engine.touching())}")
    run(engine, 0.5)
    expect_near("the position of a robot after a reset", engine.body_state(ROBOT).position, (1.0, 0.2, 0.0), 2e-3)


def resets_do_not_drift(make: Make) -> None:
    """A run after the hundredth reset is bit-identical to that after the first."""
    engine = built(make, ORIGIN)
    engine.add_body("box", body(CUBE), at(0.4, 0.0, EDGE / 2))

    def follows() -> tuple[BodyState, ...]:
        engine.reset()
        before = engine.body_state(ROBOT), engine.body_state("box")
        drive(engine, 0.3, 0.2, seconds=0.1)
        return *before, engine.body_state(ROBOT), engine.body_state("box")

    first = follows()
    for index in range(2, 101):
        again = follows()
        expect(again == first, f"after reset {index} it is {again} instead of {first}")


def diverged_states_are_reported(make: Make) -> None:
    """A step raises UnstablePhysics if states diverge; afterwards, a scene can be built again."""
    engine = built(make, ORIGIN)
    for _ in range(2):
        engine.add_body("box", body(CUBE), at(1.0, 1.0, 1.0))
        engine.set_body_state("box", BodyState((1.0, 1.0, 1.0), linear=HUGE, angular=HUGE))
        try:
            run(engine, 0.1)
        except UnstablePhysics as error:
            expect("reset" in str(error), f"the message {error} does not mention a reset of the simulation")
        else:
            for name in (ROBOT, "box"):
                position = engine.body_state(name).position
                expect(all(map(math.isfinite, position)), f"{name} is at {position}, and no step raised")
            moved = math.dist(engine.body_state("box").position, (1.0, 1.0, 1.0))
            expect(
                moved > 1.0, f"a box with {HUGE[0]:g} m/s moved {moved:.3f} m, and no step raised UnstablePhysics"
            )
        engine.build(scene(ORIGIN))
        run(engine, 0.1)
        found = engine.body_state(ROBOT).position
        expect(bool(np.isfinite(found).all()), f"a new scene after lost states has its robot at {found}")
