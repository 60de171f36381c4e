"""Rules for arms: posture, commands, grip, and predicted collisions."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from sim_nodes.check.bench import EXTENT, GRAVITY, ROBOT, Make, expect, expect_near, expect_state, run
from sim_nodes.geometry import Array, Pose2, quaternion_of, vector
from sim_nodes.manipulation.chain import Chain, pose_matrix
from sim_nodes.physics import (
    FLOOR,
    BodyModel,
    BodyState,
    Box,
    CarriedBody,
    Engine,
    Part,
    PlacedRobot,
    Scene,
    Sphere,
)
from sim_nodes.robots.reading import load_robot
from sim_nodes.ticks import TICK

UR10E = load_robot("ur10e")
assert UR10E.arm is not None
ARM = UR10E.arm
assert ARM.gripper is not None
assert ARM.tool_link is not None
GRIPPER = ARM.gripper
LEFT, RIGHT = GRIPPER.links
CHAIN = Chain(UR10E.urdf, UR10E.base_link, ARM.tool_link, [joint.name for joint in ARM.joints])
JOINTS = len(ARM.joints)
HOME = np.array([joint.home for joint in ARM.joints])
OUTSTRETCHED = np.zeros(JOINTS)
PLACED = PlacedRobot(ROBOT, UR10E, Pose2(0.5, -0.3, 0.4), 0.4)
BASE = pose_matrix(
    PLACED.state.position,
    np.array([[math.cos(0.4), -math.sin(0.4), 0.0], [math.sin(0.4), math.cos(0.4), 0.0], [0.0, 0.0, 1.0]]),
)
# Upper arm to wrist of the outstretched arm: mass of a link [kg], and its distance from the shoulder's axis [m].
WEIGHTS = ((13.051, 0.2327), (3.989, 0.94425), (2.1, 1.18425), (1.98, 1.18425), (0.615, 1.18425), (0.901, 1.18425))
CLOSED = -0.02  # [m] beyond the point where the fingers meet, to press on thin bodies as well
EDGE = 0.05  # [m] edge of the gripped cube
CUBE = BodyModel((Part(Box((EDGE, EDGE, EDGE))),), mass=0.1)
STAND = BodyModel((Part(Box((0.2, 0.2, 0.1))),), static=True)
AWAY = np.array([0.5, 0.3, -0.4, 0.3, -0.5, 0.8])  # [rad] from the home positions


def built_arm(make: Make) -> Engine:
    """Return a new engine with one arm at a height of 0.4 m."""
    engine = make()
    engine.build(Scene((), (PLACED,), EXTENT))
    return engine


def tool_at(positions: Array) -> Array:
    """Return the pose of the tool in the world at joint positions, shape (4, 4)."""
    return BASE @ CHAIN.tool_pose(positions)


def state_at(pose: Array) -> BodyState:
    """Return the state at rest at a pose of shape (4, 4)."""
    return BodyState(vector(pose[:3, 3]), quaternion_of(pose[:3, :3]))


def arm_at_cube(make: Make) -> Engine:
    """Return a new engine with an arm whose open gripper is around a cube on a stand."""
    engine = built_arm(make)
    grasp = state_at(tool_at(HOME))
    x, y, z = grasp.position
    engine.add_body("stand", STAND, BodyState((x, y, z - EDGE / 2 - 0.05)))
    engine.add_body("cube", CUBE, grasp)
    return engine


def observe_arm(engine: Engine) -> list[object]:
    """Return the observations of an arm and a cube."""
    states = engine.joint_states(ROBOT)
    seen: list[object] = [each.tobytes() for each in (states.positions, states.velocities, states.efforts)]
    return [*seen, sorted(engine.link_contacts(ROBOT)), engine.body_state("cube"), sorted(engine.touching())]


def move(engine: Engine, start: Array, goal: Array, seconds: float) -> None:
    """Move the joints at constant velocity between two configurations, by a command in every tick."""
    rate = (goal - start) / seconds
    for tick in range(round(seconds / TICK)):
        engine.command_joints(ROBOT, start + tick * TICK * rate, rate)
        run(engine, TICK)
    engine.command_joints(ROBOT, goal, np.zeros(JOINTS))


def arms_keep_their_posture(make: Make) -> None:
    """Without commands, an arm stays where it was placed, with its joints at home and its gripper open."""
    engine = built_arm(make)
    for after in (0.0, 1.0):
        run(engine, after)
        states = engine.joint_states(ROBOT)
        opened = (*HOME, GRIPPER.stroke / 2, GRIPPER.stroke / 2)
        expect_state(f"the base after {after} s", engine.body_state(ROBOT), PLACED.state, 1e-9)
        expect_near(f"the positions of the joints and fingers after {after} s", states.positions, opened, 1e-3)
        expect_near(f"their velocities after {after} s", states.velocities, np.zeros(JOINTS + 2), 1e-3)


def joints_reach_their_targets(make: Make) -> None:
    """Each joint reaches its target position within 2 mrad, and stays there."""
    engine = built_arm(make)
    engine.command_joints(ROBOT, HOME + 0.2 * AWAY, np.zeros(JOINTS))
    for after in (2.0, 1.0):
        run(engine, after)
        states = engine.joint_states(ROBOT)
        expect_near("the positions of the joints [rad]", states.positions[:JOINTS], HOME + 0.2 * AWAY, 2e-3)
        expect_near("their velocities [rad/s]", states.velocities[:JOINTS], np.zeros(JOINTS), 1e-2)


def joints_follow_moving_targets(make: Make) -> None:
    """Joints with moving targets follow their velocities, and lag by 10 mrad at most."""
    engine = built_arm(make)
    move(engine, HOME, HOME + 0.5 * AWAY, 0.5)
    rate = 0.8 * AWAY
    for tick in range(50):
        engine.command_joints(ROBOT, HOME + 0.5 * AWAY + tick * TICK * rate, rate)
        run(engine, TICK)
        if tick > 20:
            states = engine.joint_states(ROBOT)
            where = HOME + 0.5 * AWAY + (tick + 1) * TICK * rate
            expect_near("the positions of joints that move [rad]", states.positions[:JOINTS], where, 1e-2)
            expect_near("the velocities of joints that move [rad/s]", states.velocities[:JOINTS], rate, 5e-2)
    run(engine, 0.5)
    moved = engine.joint_states(ROBOT).positions[:JOINTS] - HOME
    expect(bool(np.all(np.abs(moved) > np.abs(1.6 * AWAY))), "joints do not follow the velocities of a command")


def motors_support_the_weight(make: Make) -> None:
    """The shoulder effort of an outstretched arm equals the torque of its weight within 2 %."""
    engine = built_arm(make)
    move(engine, HOME, OUTSTRETCHED, 2.0)
    run(engine, 1.0)
    wanted = -GRAVITY * sum(mass * reach for mass, reach in WEIGHTS)
    effort = float(engine.joint_states(ROBOT).efforts[1])
    expect_near("the effort of the second joint [N m]", effort, wanted, 0.02 * abs(wanted))


def fingers_press_with_the_commanded_force(make: Make) -> None:
    """Blocked fingers press with the force of their command, within 5 %."""
    engine = built_arm(make)
    block = BodyModel((Part(Box((0.04, 0.04, 0.04))),), static=True)
    engine.add_body("block", block, state_at(tool_at(HOME)))
    expect(not engine.link_contacts(ROBOT), "an open gripper around a body touches it")
    for force in (30.0, 100.0):
        engine.command_fingers(ROBOT, CLOSED, force)
        run(engine, 1.5)
        states = engine.joint_states(ROBOT)
        expect_near("the positions of the fingers [m]", states.positions[JOINTS:], (0.02, 0.02), 2e-3)
        expect_near("the efforts of the fingers [N]", states.efforts[JOINTS:], (-force, -force), 0.05 * force)
        expect_contacts(engine, ((LEFT, "block"), (RIGHT, "block")))
    engine.command_fingers(ROBOT, GRIPPER.stroke / 2, 50.0)
    run(engine, 1.0)
    expect_contacts(engine, ())


def expect_contacts(engine: Engine, wanted: Iterable[tuple[str, str]]) -> None:
    """Expect that the links of the arm touch exactly these entities."""
    found = engine.link_contacts(ROBOT)
    expect(found == set(wanted), f"the links touch {sorted(found)} instead of {sorted(wanted)}")


def gripped_bodies_are_carried(make: Make) -> None:
    """A gripped cube is lifted with the arm, slips by less than 3 mm in 2 s, and falls when released."""
    engine = arm_at_cube(make)
    z = float(tool_at(HOME)[2, 3])
    run(engine, 0.2)
    engine.command_fingers(ROBOT, CLOSED, 40.0)
    run(engine, 1.0)
    lifted = HOME + np.array([0.0, -0.3, 0.0, 0.3, 0.0, 0.0])
    move(engine, HOME, lifted, 1.0)
    run(engine, 0.5)
    before = engine.body_state("cube")
    rise = float(tool_at(lifted)[2, 3]) - z
    expect_near("how far the cube was lifted [m]", before.position[2] - z, rise, 5e-3)
    run(engine, 2.0)
    expect_near("where it is 2 s later [m]", engine.body_state("cube").position, before.position, 3e-3)
    engine.command_fingers(ROBOT, GRIPPER.stroke / 2, 40.0)
    run(engine, 1.0)
    fallen = engine.body_state("cube").position[2]
    expect(fallen < before.position[2] - 0.1, "a cube that was released does not fall")


def predicted_overlaps_match_kinematics(make: Make) -> None:
    """Predicted overlaps of an arm agree with its kinematics within 1 cm."""
    engine = built_arm(make)
    engine.command_fingers(ROBOT, 0.0, 50.0)
    run(engine, 1.5)
    ball = BodyModel((Part(Sphere(0.012)),), static=True)
    draw = np.random.Generator(np.random.Philox(1))
    for positions in draw.uniform(-1.5, 1.5, size=(8, JOINTS)):
        tool = tool_at(positions)
        for ahead, inside in ((0.0, {LEFT, RIGHT}), (0.015 + 0.012 + 0.01, set())):
            engine.add_body("ball", ball, state_at(tool @ pose_matrix((0.0, 0.0, ahead), np.eye(3))))
            found = {it.link for it in engine.arm_overlaps(ROBOT, positions, (), None) if it.other == "ball"}
            engine.remove_body("ball")
            expect(found == inside, f"a ball {ahead:.3f} m ahead of the tool overlaps {sorted(found)}")


def predicted_overlaps_include_floor_and_links(make: Make) -> None:
    """Predicted overlaps include the floor, the arm itself, and the body that it carries."""
    engine = built_arm(make)
    engine.add_body("cube", CUBE, BodyState((3.0, 3.0, EDGE / 2)))
    low, folded = HOME + np.array([0, 1.5, -0.5, 0, 0, 0]), HOME + np.array([0, 0, 1.3, 0, 0, 0])
    own = (("upper_arm_link", "gripper_palm"), ("base_link", "wrist_1_link"))
    expect(not engine.arm_overlaps(ROBOT, HOME, own, None), "an arm at home overlaps something")
    below = {it.other for it in engine.arm_overlaps(ROBOT, low, (), None)}
    expect(FLOOR in below, f"an arm that reaches into the floor overlaps {sorted(below)}")
    pairs = {(it.link, it.other) for it in engine.arm_overlaps(ROBOT, folded, own, None)}
    expect(pairs == {own[0]}, f"a folded arm overlaps itself in {sorted(pairs)} instead of {own[0]}")
    expect(not engine.arm_overlaps(ROBOT, folded, (), None), "pairs of links are returned that were not requested")
    for height, wanted in ((0.2, set()), (0.0, {("cube", FLOOR)})):
        carried = CarriedBody("cube", BodyState((1.0, 1.0, height)))
        pairs = {(it.link, it.other) for it in engine.arm_overlaps(ROBOT, HOME, (), carried)}
        expect(pairs == wanted, f"with a carried cube at a height of {height} m, {sorted(pairs)} overlap")


def predicting_overlaps_changes_nothing(make: Make) -> None:
    """Predicting overlaps leaves the state bit-identical."""
    expect(_seen(make, ask=True) == _seen(make, ask=False), "a run with predictions differs from one without")


def _seen(make: Make, *, ask: bool) -> list[object]:
    engine = arm_at_cube(make)
    engine.command_fingers(ROBOT, CLOSED, 40.0)
    engine.command_joints(ROBOT, HOME + 0.1 * AWAY, np.zeros(JOINTS))
    seen: list[object] = []
    for _ in range(20):
        if ask:
            carried = CarriedBody("cube", BodyState((1.0, 1.0, 0.01)))
            engine.arm_overlaps(ROBOT, HOME + AWAY, (("base_link", "wrist_1_link"),), carried)
        run(engine, TICK)
        seen += observe_arm(engine)
    return seen


def a_reset_returns_arms_home(make: Make) -> None:
    """After a reset, an arm is at home, holds its posture, and has no force left."""
    engine = built_arm(make)
    start = engine.joint_states(ROBOT)
    first = _follows(engine)
    engine.command_joints(ROBOT, HOME + AWAY, 0.1 * AWAY)
    engine.command_fingers(ROBOT, CLOSED, 20.0)
    run(engine, 1.0)
    engine.reset()
    states = engine.joint_states(ROBOT)
    expect_near("the positions of the joints after a reset", states.positions, start.positions, 0.0)
    expect_near("their velocities", states.velocities, np.zeros(JOINTS + 2), 0.0)
    expect(_follows(engine) == first, "a run after a reset differs from the first one")


def _follows(engine: Engine) -> bytes:
    run(engine, 0.5)
    return engine.joint_states(ROBOT).positions.tobytes()
