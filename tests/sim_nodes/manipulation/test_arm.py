from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import ArmResult, Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import Client, pose
from tests.sim_nodes.manipulation.cell import ARM, HOME, TABLE, Cell, box, down

AWAY = (0.5, -1.2, 1.2, -1.5, -1.2, 0.7)
TOLERANCE = 1e-3


@pytest.fixture
def cell() -> Cell:
    return Cell()


def refused(action: object, *arguments: object, **more: object) -> RequestRefused:
    with pytest.raises(RequestRefused) as caught:
        action(*arguments, **more)  # type: ignore[operator]
    return caught.value


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_joints_pass_waypoints_within_their_limits(engine: str) -> None:
    cell = Cell(engine)
    cell.start_joints(AWAY, HOME, max_velocity_scaling_factor=0.4)
    speeds: list[tuple[float, ...]] = []
    reached: list[float] = []
    while cell.state.remaining or not reached:
        cell.advance(cell.now + 0.02)
        states = cell.joints
        speeds.append(states.velocities[:6])
        reached.append(float(np.abs(np.subtract(states.positions[:6], AWAY)).max()))
    cell.end()
    assert min(reached) < 0.05
    np.testing.assert_allclose(cell.joints.positions[:6], HOME, atol=TOLERANCE)
    highest = np.abs(speeds).max(axis=0) / np.radians([120, 120, 180, 180, 180, 180])
    assert 0.35 < highest.max() < 0.42


def test_joint_names_define_the_order_of_positions(cell: Cell) -> None:
    names = cell.joints.names
    assert names[:2] == ("shoulder_pan_joint", "shoulder_lift_joint")
    assert len(names) == 8
    cell.start_joints(AWAY[::-1], joint_names=names[5::-1])
    assert cell.end().outcome is Outcome.SUCCEEDED
    np.testing.assert_allclose(cell.joints.positions[:6], AWAY, atol=TOLERANCE)
    error = refused(cell.start_joints, AWAY, joint_names=("a", *names[1:6]))
    assert "expected different ones of ur10e: shoulder_pan_joint" in error.message


def test_the_tool_moves_to_a_pose(cell: Cell) -> None:
    cell.start_tool(down(0.7, 0.2, TABLE + 0.2, 0.4), frame="map")
    assert cell.end().outcome is Outcome.SUCCEEDED
    tool = cell.state.tool
    position = (tool.position.x, tool.position.y, tool.position.z)
    assert position == pytest.approx((0.7, 0.2, TABLE + 0.2), abs=2e-3)
    assert abs(tool.orientation.roll) == pytest.approx(math.pi, abs=5e-3)
    assert tool.orientation.yaw == pytest.approx(0.4, abs=5e-3)


def test_the_tool_moves_in_a_straight_line(cell: Cell) -> None:
    cell.move(down(0.6, -0.3, 0.2, -0.5))
    cell.start_tool(down(0.8, 0.3, 0.1, 0.5), straight=True)
    start, way = np.array((0.6, -0.3, 0.2)), np.array((0.2, 0.6, -0.1))
    while cell.state.remaining:
        cell.advance(cell.now + 0.02)
        place = cell.state.tool.position
        off = np.array((place.x, place.y, place.z - TABLE)) - start
        assert np.linalg.norm(np.cross(off, way)) / np.linalg.norm(way) < 5e-3
    assert cell.end().outcome is Outcome.SUCCEEDED


@pytest.mark.parametrize(
    ("target", "straight", "code", "words"),
    [
        (
            down(2.0, 0.0, 0.2),
            False,
            ArmResult.UNREACHABLE,
            "the tool of ur10e cannot reach (2.000, 0.000, 0.900)",
        ),
        (down(1.2, 0.9, 0.2), True, ArmResult.UNREACHABLE, "cannot follow the straight line"),
        (down(0.7, 0.0, -0.05), False, ArmResult.IN_COLLISION, "with 'table'"),
        (down(0.7, 0.0, 0.005), True, ArmResult.IN_COLLISION, "at its goal: left_finger with 'table'"),
        (down(0.0, 0.0, 0.5), True, ArmResult.UNREACHABLE, "the arm would flip"),
    ],
)
def test_unreachable_poses_are_refused(
    cell: Cell, target: wire.Pose3D, straight: bool, code: ArmResult, words: str
) -> None:
    error = refused(cell.start_tool, target, straight=straight)
    assert words in error.message
    assert error.code == code
    assert cell.state.remaining == 0.0


@pytest.mark.parametrize(
    ("points", "more", "words"),
    [
        ((), {}, "found 0 waypoints"),
        ((HOME[:5],), {}, "a finite number for each of shoulder_pan_joint"),
        (((math.nan, *HOME[1:]),), {}, "a finite number for each of"),
        (((7.0, *HOME[1:]),), {}, "7.000 rad of shoulder_pan_joint of ur10e; expected -6.283 to 6.283 rad"),
        ((AWAY,), {"max_velocity_scaling_factor": 1.5}, "invalid velocity scaling factor 1.5"),
        ((AWAY,), {"max_velocity_scaling_factor": 0.0}, "invalid velocity scaling factor 0"),
        ((AWAY,), {"tolerance": -1.0}, "invalid tolerance -1.0"),
        (((0.0, -1.5, 2.9, 0.5, -1.57, 0.0),), {}, "would collide"),
        (((0.0, 0.3, 0.0, 0.0, 0.0, 0.0),), {}, "would collide"),
    ],
)
def test_invalid_waypoints_are_refused(
    cell: Cell, points: tuple[tuple[float, ...], ...], more: dict[str, float], words: str
) -> None:
    assert words in refused(cell.start_joints, *points, **more).message


def test_an_unknown_frame_joint_or_robot_is_refused(cell: Cell, empty: Client) -> None:
    message = refused(cell.start_tool, down(0.7, 0, 0.3), frame="odom").message
    assert "frames: base_link, map, ur10e/base_link" in message
    watch = wire.WatchJoint(id="w", robot=ARM, joint="knee", position=0.0, tolerance=0.1)
    assert "unknown joint 'knee'" in refused(cell.ask, wire.WATCH_JOINT, watch).message
    error = refused(empty.ask, wire.GET_ARM_STATE, wire.RobotName(robot="turtlebot4"))
    assert (error.code, error.message) == (Result.FEATURE_UNSUPPORTED, "turtlebot4 has no arm")
    drive = wire.NavigateThroughPoses(id="g", robot=ARM, poses=(pose(1.0, 0.0),))
    assert refused(cell.ask, wire.NAVIGATE_THROUGH_POSES, drive).message == "ur10e has no wheeled base"
    put = wire.SetEntityState(name=ARM, pose=pose(1.0, 0.0))
    assert (
        "'ur10e' cannot be moved: it is fixed to the world"
        in refused(cell.ask, wire.SET_ENTITY_STATE, put).message
    )


def test_a_second_motion_is_refused_while_the_arm_moves(cell: Cell) -> None:
    cell.start_joints(AWAY)
    assert "ur10e is busy with goal 'move'" in refused(cell.start_joints, HOME, goal="second").message
    assert "duplicate id 'move'" in refused(cell.start_gripper, 0.04, goal="move").message


def test_planning_only_does_not_move_the_arm(cell: Cell) -> None:
    before = cell.joints
    cell.start_joints(AWAY, plan_only=True)
    assert cell.end().outcome is Outcome.SUCCEEDED
    cell.advance(cell.now + 0.5)
    np.testing.assert_allclose(cell.joints.positions, before.positions, atol=1e-6)
    assert "would collide" in refused(cell.start_tool, down(0.7, 0.0, -0.05), plan_only=True).message


def test_a_canceled_motion_comes_to_rest_and_the_next_begins_there(cell: Cell) -> None:
    cell.start_joints(AWAY)
    cell.advance(0.4)
    assert np.abs(cell.joints.velocities).max() > 0.3
    cell.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="move"))
    assert cell.end().outcome is Outcome.CANCELED
    cell.advance(cell.now + 0.4)
    still = cell.joints
    assert np.abs(still.velocities).max() < 0.01
    assert 0.05 < still.positions[0] < 0.45
    cell.advance(cell.now + 1.0)
    np.testing.assert_allclose(cell.joints.positions, still.positions, atol=2e-3)
    cell.start_joints(AWAY, max_velocity_scaling_factor=1.0)
    cell.advance(cell.now + 0.3)
    cell.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="move"))
    cell.end()
    cell.start_joints(HOME, goal="back")
    assert cell.end("back").outcome is Outcome.SUCCEEDED


def test_a_stopped_robot_cancels_everything_and_holds_still(cell: Cell) -> None:
    cell.start_joints(AWAY)
    cell.start_gripper(0.0)
    cell.advance(0.3)
    cell.ask(wire.STOP_ROBOT, wire.StopRobot(robot=ARM))
    ended = {happened.id: happened.outcome for happened in cell.advance(cell.now + 0.4).occurrences}
    assert ended == {"move": Outcome.CANCELED, "grip": Outcome.CANCELED}
    cell.advance(cell.now + 0.6)
    still = cell.joints.positions
    cell.advance(cell.now + 1.0)
    np.testing.assert_allclose(cell.joints.positions, still, atol=2e-3)
    assert 0.03 < cell.state.opening < 0.08


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_an_obstacle_stops_the_arm(engine: str) -> None:
    cell = Cell(engine)
    cell.start_joints((1.0, *HOME[1:]), max_velocity_scaling_factor=0.3)
    cell.advance(0.3)
    cell.spawn("post", pose(0.55, 0.55, z=TABLE + 0.4), box(0.1, 0.1, 0.7, static=True))
    ended = cell.end()
    assert ended.outcome is Outcome.ABORTED
    assert "shoulder_pan_joint was blocked" in ended.message
    assert "touches 'post'" in ended.message
    cell.advance(cell.now + 0.5)
    assert np.abs(cell.joints.velocities[:6]).max() < 0.02


def test_bodies_that_may_be_touched_are_pushed(cell: Cell) -> None:
    cell.place("cube", 0.7, 0.0, 0.025)
    cell.grip()
    cell.move(down(0.7, -0.15, 0.03))
    target = down(0.7, 0.1, 0.03)
    assert "with 'cube'" in refused(cell.start_tool, target, straight=True).message
    cell.start_tool(target, straight=True, may_touch=("cube",))
    assert cell.end().outcome is Outcome.SUCCEEDED
    x, y, _ = cell.where("cube")
    assert x == pytest.approx(0.7, abs=0.03)
    assert y > 0.12


def test_two_arms_do_not_collide(tmp_path: Path) -> None:
    world = tmp_path / "arms.yaml"
    world.write_text(
        "name: arms\nextent: [-2, -2, 3, 2]\nrobots:\n"
        "  - {name: left, robot: ur10e, pose: {x: 0, y: 0, z: 0.5}}\n"
        "  - {name: right, robot: ur10e, pose: {x: 1.3, y: 0, z: 0.5, yaw: 3.14159}}\n"
        "  - {name: turtlebot4, robot: turtlebot4, pose: {x: 0.6, y: -1.2}}\n"
    )
    client = Client(str(world))
    for robot in ("left", "right"):
        request = wire.MoveToPose(id=robot, robot=robot, pose=down(0.5, 0.3, 0.5), frame="base_link")
        client.ask(wire.MOVE_TO_POSE, request)
    assert client.run_until("left")[0].outcome is Outcome.SUCCEEDED
    request = wire.MoveToPose(id="across", robot="left", pose=down(0.8, -0.3, 0.5), frame="base_link")
    assert "with 'right'" in refused(client.ask, wire.MOVE_TO_POSE, request).message


def test_a_joint_is_watched(cell: Cell) -> None:
    watch = wire.WatchJoint(id="near", robot=ARM, joint="shoulder_pan_joint", position=0.25, tolerance=0.01)
    cell.ask(wire.WATCH_JOINT, watch)
    cell.start_joints(AWAY, max_velocity_scaling_factor=0.2)
    assert cell.end("near").outcome is Outcome.SUCCEEDED
    assert cell.joints.positions[0] == pytest.approx(0.25, abs=0.011)


def test_a_joint_that_passes_its_target_between_ticks_is_reported(cell: Cell) -> None:
    watch = wire.WatchJoint(id="past", robot=ARM, joint="wrist_3_joint", position=0.3, tolerance=1e-6)
    cell.ask(wire.WATCH_JOINT, watch)
    cell.start_joints(AWAY)
    assert cell.end("past").outcome is Outcome.SUCCEEDED
    assert cell.joints.positions[5] == pytest.approx(0.3, abs=0.06)


def test_a_state_reset_returns_the_arm_home(cell: Cell) -> None:
    cell.start_joints(AWAY)
    cell.advance(0.5)
    cell.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE))
    assert cell.end().outcome is Outcome.CANCELED
    np.testing.assert_allclose(cell.joints.positions[:6], HOME, atol=1e-6)
    cell.advance(cell.now + 0.5)
    np.testing.assert_allclose(cell.joints.positions[:6], HOME, atol=1e-3)
    cell.move(down(0.7, 0.2, 0.2))
