"""Rules for engines that save their state, or go back a little (see `SavesState`, `Rewinds`)."""

from __future__ import annotations

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
    run,
)
from sim_nodes.check.bodies import LOPSIDED, MOVING
from sim_nodes.check.rays import DIRECTIONS, LIMIT, ROOM
from sim_nodes.codec import pack, unpack
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.physics import BodyState, Engine, Rewinds, SavesState

SECOND = Pose2(1.0, 0.2, 3.0)
HEAP = 9  # bodies
PATIENCE = 400  # steps in which an engine has to have a way back


def look(engine: Engine, *names: str) -> list[object]:
    """Everything that can be seen of an engine."""
    seen: list[object] = [engine.body_state(name) for name in (ROBOT, OTHER, *names)]
    seen += [engine.wheel_angles(ROBOT), engine.wheel_angles(OTHER), sorted(engine.touching())]
    seen += [engine.overlaps(name) for name in (ROBOT, *names)]
    seen.append(engine.cast_rays(ROBOT, DIRECTIONS, LIMIT).tobytes())
    return seen


def follow(engine: Engine, *names: str) -> list[list[object]]:
    """What is seen of an engine in the next 0.6 s."""
    seen = []
    for _ in range(4):
        run(engine, 0.15)
        seen.append(look(engine, *names))
    return seen


def saved(engine: Engine) -> Any:
    """The state of an engine as it comes out of a file."""
    assert isinstance(engine, SavesState)
    return unpack(pack(engine.save()))


def restore(engine: Engine, state: Any) -> None:
    """Restore a state."""
    assert isinstance(engine, SavesState)
    engine.restore(state)


def eventful(make: Make) -> tuple[Engine, tuple[str, ...]]:
    """An engine in the midst of much, and the names of its bodies: heaps, contacts, robots that drive and push."""
    engine = built(make, ORIGIN, SECOND, walls=ROOM)
    drive(engine, 0.3, 0.4)
    drive(engine, 0.2, -0.3, OTHER)
    names = [f"body{index}" for index in range(HEAP)]
    for index, name in enumerate(names):
        turned = BodyState((0.55, 0.1, 0.15 + 0.2 * index), quaternion(0.3 * index, 0.2, 0.1))
        engine.add_body(name, body(SHAPES[index % len(SHAPES)]), turned)
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
    return engine, (*names, "thing", "table")


def what_is_restored_goes_on_as_it_did(make: Make) -> None:
    """An engine that is restored goes on bit for bit as the one that was saved, also in another engine."""
    engine, names = eventful(make)
    state = saved(engine)
    before, after = look(engine, *names), follow(engine, *names)
    other = built(make, ORIGIN, SECOND, walls=ROOM)
    for what, restored in (("another engine", other), ("the same engine", engine), ("it, again", engine)):
        restore(restored, state)
        _expect_same(f"{what}, just restored,", [before], [look(restored, *names)])
        _expect_same(what, after, follow(restored, *names))


def saving_changes_nothing(make: Make) -> None:
    """A run in which states are saved is the one in which none are."""
    quiet, names = eventful(make)
    watched, _ = eventful(make)
    for _ in range(3):
        saved(watched)
        run(quiet, 0.1)
        run(watched, 0.1)
    _expect_same("an engine that was saved", follow(quiet, *names), follow(watched, *names))


def what_was_added_since_is_gone_again(make: Make) -> None:
    """Bodies that were added after a state was saved are gone when it is restored, and those removed are back."""
    engine = built(make, ORIGIN, SECOND)
    engine.add_body("early", body(CUBE), at(2.0, 2.0, EDGE / 2))
    state = saved(engine)
    after = follow(engine, "early")
    engine.remove_body("early")
    engine.add_body("late", body(CUBE), at(-2.0, 2.0, EDGE / 2))
    restore(engine, state)
    _expect_same("an engine in which a body was exchanged", after, follow(engine, "early"))
    engine.add_body("late", body(CUBE), at(-2.0, 2.0, EDGE / 2))
    expect(engine.body_state("late").position[0] < 0, "a body of the name of one that is gone cannot be added")


def a_restored_engine_resets_as_any_other(make: Make) -> None:
    """What was added before a state was saved goes back to where it was added when the engine is reset later."""
    first, names = eventful(make)
    second = built(make, ORIGIN, SECOND, walls=ROOM)
    restore(second, saved(first))
    for engine in (first, second):
        run(engine, 0.2)
        engine.reset()
    _expect_same("a restored engine that was reset", [look(first, *names)], [look(second, *names)])
    _expect_same("a restored engine that was reset", follow(first, *names), follow(second, *names))
    state = saved(first)
    restore(second, state)
    _expect_same("an engine saved after a reset", follow(first, *names), follow(second, *names))


def gripping(make: Make) -> Engine:
    """An engine with an arm that moves and grips a cube."""
    engine = arms.built_arm(make)
    place = arms.state_at(arms.tool_at(arms.HOME))
    engine.add_body("stand", arms.STAND, BodyState((*place.position[:2], place.position[2] - 0.08)))
    engine.add_body("cube", arms.CUBE, place)
    engine.command_fingers(ROBOT, arms.CLOSED, 30.0)
    run(engine, 1.0)
    engine.command_joints(ROBOT, arms.HOME, 0.2 * arms.AWAY)
    run(engine, 0.3)
    return engine


def arms_that_are_restored_go_on_as_they_did(make: Make) -> None:
    """An arm that is restored while it moves and grips goes on bit for bit, also in another engine."""
    engine = gripping(make)
    state = saved(engine)
    before, after = look_at_arm(engine), follow_arm(engine)
    other = arms.built_arm(make)
    for what, restored in (("another arm", other), ("the same arm", engine)):
        restore(restored, state)
        _expect_same(f"{what}, just restored,", [before], [look_at_arm(restored)])
        _expect_same(what, after, follow_arm(restored))


def checkpoint_of(engine: Engine) -> Any:
    """The first of an engine's checkpoints from now on."""
    assert isinstance(engine, Rewinds)
    for _ in range(PATIENCE):
        checkpoint = engine.checkpoint()
        if checkpoint is not None:
            return checkpoint
        engine.step()
    raise AssertionError(f"there is no way back from any of {PATIENCE} steps")


def what_is_rewound_goes_on_as_it_did(make: Make) -> None:
    """An engine that is rewound goes on bit for bit as it did, also when it is rewound to the same state again."""
    engine, names = eventful(make)
    assert isinstance(engine, Rewinds)
    checkpoint = checkpoint_of(engine)
    before, after = look(engine, *names), follow(engine, *names)
    for _ in range(2):
        drive(engine, -0.2, 0.5, OTHER)
        engine.power_wheels(OTHER, True)
        run(engine, 0.2)
        engine.rewind(checkpoint)
        _expect_same("an engine, just rewound,", [before], [look(engine, *names)])
        _expect_same("an engine that was rewound", after, follow(engine, *names))


def arms_that_are_rewound_go_on_as_they_did(make: Make) -> None:
    """An arm that is rewound while it moves and grips goes on bit for bit."""
    engine = gripping(make)
    assert isinstance(engine, Rewinds)
    checkpoint = checkpoint_of(engine)
    before, after = look_at_arm(engine), follow_arm(engine)
    engine.rewind(checkpoint)
    _expect_same("an arm, just rewound,", [before], [look_at_arm(engine)])
    _expect_same("an arm that was rewound", after, follow_arm(engine))


def look_at_arm(engine: Engine) -> list[object]:
    """Everything that can be seen of an engine with an arm and a cube."""
    states = engine.joint_states(ROBOT)
    seen: list[object] = [each.tobytes() for each in (states.positions, states.velocities, states.efforts)]
    return [*seen, sorted(engine.link_contacts(ROBOT)), engine.body_state("cube"), sorted(engine.touching())]


def follow_arm(engine: Engine) -> list[list[object]]:
    """What is seen of an arm in the next 0.6 s, in which it is told to go elsewhere and to let go."""
    seen = []
    for pull in (arms.HOME, arms.HOME + 0.3 * arms.AWAY):
        run(engine, 0.2)
        seen.append(look_at_arm(engine))
        engine.command_joints(ROBOT, pull, 0.1 * arms.AWAY)
    engine.command_fingers(ROBOT, arms.GRIPPER.stroke / 2, 20.0)
    run(engine, 0.2)
    return [*seen, look_at_arm(engine)]


def _expect_same(what: str, first: list[list[object]], second: list[list[object]]) -> None:
    for moment, (one, other) in enumerate(zip(first, second, strict=True)):
        for index, (wanted, found) in enumerate(zip(one, other, strict=True)):
            expect(
                wanted == found,
                f"{what} differs at moment {moment} in observation {index}: {found!r} instead of {wanted!r}",
            )
