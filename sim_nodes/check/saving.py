"""Rules for engines that save their state (`SavesState`) or go back a little (`Rewinds`)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import cycle
from typing import Any

from sim_nodes.check import arms
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
    expect_same,
    run,
)
from sim_nodes.check.bodies import LOPSIDED, MOVING
from sim_nodes.check.repeating import SECOND, observe, observe_run
from sim_nodes.check.sensing import ROOM
from sim_nodes.codec import pack, unpack
from sim_nodes.geometry import quaternion
from sim_nodes.physics import BodyState, Engine, Rewinds, SavesState

HEAP = 9  # bodies of a heap
PATIENCE = 400  # steps within which an engine must give a checkpoint

Observe = Callable[[Engine], list[object]]


def saved(engine: Engine) -> Any:
    """Return the state of an engine after encoding and decoding."""
    assert isinstance(engine, SavesState)
    return unpack(pack(engine.save()))


def restore(engine: Engine, state: Any) -> None:
    """Restore a state."""
    assert isinstance(engine, SavesState)
    engine.restore(state)


def eventful(make: Make) -> tuple[Engine, Observe, Observe]:
    """Return an engine with heaps, contacts, driving and pushing robots; and its `observe` and `observe_run`."""
    engine = built(make, ORIGIN, SECOND, walls=ROOM)
    drive(engine, 0.3, 0.4)
    drive(engine, 0.2, -0.3, OTHER)
    names = [f"body{index}" for index in range(HEAP)]
    for index, (name, shape) in enumerate(zip(names, cycle(SHAPES.values()), strict=False)):
        turned = BodyState((0.55, 0.1, 0.15 + 0.2 * index), quaternion(0.3 * index, 0.2, 0.1))
        engine.add_body(name, body(shape), turned)
    run(engine, 0.7)
    for name in (names[3], names[0], names[7]):
        engine.remove_body(name)
        names.remove(name)
    engine.set_body_state(OTHER, BodyState((-0.5, 0.0, 0.0)))
    engine.add_body("thing", LOPSIDED, MOVING)
    engine.add_body("table", body(CUBE, static=True), at(0.8, -0.5, EDGE / 2))
    run(engine, 0.3)
    engine.power_wheels(OTHER, False)
    engine.set_body_state("table", at(0.8, -0.7, EDGE / 2))
    drive(engine, 0.25, 0.3)
    names += ["thing", "table"]
    return engine, partial(observe, names=names), partial(observe_run, names=names)


def restored_engines_continue_identically(make: Make) -> None:
    """A restored engine continues bit-identically to the saved one, also in another engine."""
    engine, now, later = eventful(make)
    _expect_restorable(engine, built(make, ORIGIN, SECOND, walls=ROOM), now, later)


def _expect_restorable(engine: Engine, other: Engine, now: Observe, later: Observe) -> None:
    state = saved(engine)
    before, after = now(engine), later(engine)
    for what, restored in (("another engine", other), ("the same engine", engine), ("it, again", engine)):
        restore(restored, state)
        expect_same(f"{what}, just restored,", before, now(restored))
        expect_same(what, after, later(restored))


def saving_changes_nothing(make: Make) -> None:
    """Saving leaves the states of a run bit-identical."""
    quiet, _, later = eventful(make)
    watched, _, _ = eventful(make)
    for _ in range(3):
        saved(watched)
        run(quiet, 0.1)
        run(watched, 0.1)
    expect_same("an engine that was saved", later(quiet), later(watched))


def restoring_removes_later_bodies(make: Make) -> None:
    """Restoring a state removes bodies that were added since, and brings back removed ones."""
    engine = built(make, ORIGIN, SECOND)
    engine.add_body("early", body(CUBE), at(2.0, 2.0, EDGE / 2))
    state = saved(engine)
    after = observe_run(engine, ["early"])
    engine.remove_body("early")
    engine.add_body("late", body(CUBE), at(-2.0, 2.0, EDGE / 2))
    restore(engine, state)
    expect_same("an engine in which a body was exchanged", after, observe_run(engine, ["early"]))
    engine.add_body("late", body(CUBE), at(-2.0, 2.0, EDGE / 2))
    expect(engine.body_state("late").position[0] < 0, "a body of the name of a removed one cannot be added")


def restored_engines_reset_as_others(make: Make) -> None:
    """After a reset, a restored engine has its bodies where they were added."""
    first, now, later = eventful(make)
    second = built(make, ORIGIN, SECOND, walls=ROOM)
    restore(second, saved(first))
    for engine in (first, second):
        run(engine, 0.2)
        engine.reset()
    for look in (now, later):
        expect_same("a restored engine that was reset", look(first), look(second))
    restore(second, saved(first))
    expect_same("an engine saved after a reset", later(first), later(second))


def gripping(make: Make) -> Engine:
    """Return an engine with an arm that moves and grips a cube."""
    engine = arms.arm_at_cube(make)
    engine.command_fingers(ROBOT, arms.CLOSED, 30.0)
    run(engine, 1.0)
    engine.command_joints(ROBOT, arms.HOME, 0.2 * arms.AWAY)
    run(engine, 0.3)
    return engine


def restored_arms_continue_identically(make: Make) -> None:
    """An arm restored while it moves and grips continues bit-identically, also in another engine."""
    _expect_restorable(gripping(make), arms.built_arm(make), arms.observe_arm, observe_arm_run)


def checkpoint_of(engine: Engine) -> Any:
    """Return the next checkpoint that an engine gives."""
    assert isinstance(engine, Rewinds)
    for _ in range(PATIENCE):
        checkpoint = engine.checkpoint()
        if checkpoint is not None:
            return checkpoint
        engine.step()
    raise AssertionError(f"no checkpoint within {PATIENCE} steps")


def rewound_engines_continue_identically(make: Make) -> None:
    """A rewound engine continues bit-identically, also after a second rewind to the same state."""
    engine, now, later = eventful(make)

    def disturb() -> None:
        drive(engine, -0.2, 0.5, OTHER)
        engine.power_wheels(OTHER, True)
        run(engine, 0.2)

    _expect_rewindable(engine, now, later, disturb)


def rewound_arms_continue_identically(make: Make) -> None:
    """An arm rewound while it moves and grips continues bit-identically."""
    _expect_rewindable(gripping(make), arms.observe_arm, observe_arm_run, lambda: None)


def _expect_rewindable(engine: Engine, now: Observe, later: Observe, disturb: Callable[[], None]) -> None:
    assert isinstance(engine, Rewinds)
    checkpoint = checkpoint_of(engine)
    before, after = now(engine), later(engine)
    for _ in range(2):
        disturb()
        engine.rewind(checkpoint)
        expect_same("an engine, just rewound,", before, now(engine))
        expect_same("an engine that was rewound", after, later(engine))


def observe_arm_run(engine: Engine) -> list[object]:
    """Return the observations of an arm in the next 0.6 s, with commands to move and to release."""
    seen = []
    for goal in (arms.HOME, arms.HOME + 0.3 * arms.AWAY):
        run(engine, 0.2)
        seen += arms.observe_arm(engine)
        engine.command_joints(ROBOT, goal, 0.1 * arms.AWAY)
    engine.command_fingers(ROBOT, arms.GRIPPER.stroke / 2, 20.0)
    run(engine, 0.2)
    return seen + arms.observe_arm(engine)
