"""Grippers whose fingers turn, with links that follow."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.robotics.geometry import Pose3D, Position3D
from sim_nodes.robots.declaration import FingerMotion, GripperDeclaration
from sim_nodes.robots.reading import load_robot
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.cell import box, down
from tests.sim_nodes.manipulation.test_bodies_of_joints import ENGINES
from tests.sim_nodes.test_snapshots import restore, save

pytest.importorskip("pybullet_data")
WORLD = """
name: w
extent: [-2, -2, 2, 2]
walls: [{name: table, center: [0.4, 0.0], size: [0.2, 0.4], height: 0.1}]
robots: [{name: mine, robot: xarm6_gripper}]
"""
EDGE = 0.05  # [m] of the cube


def gripper() -> GripperDeclaration:
    """Return the gripper of the xArm6."""
    arm = load_robot("xarm6_gripper").arm
    assert arm is not None and arm.gripper is not None
    return arm.gripper


def start(folder: Path, engine: str) -> Client:
    """Start a simulation of an arm behind a table with a cube."""
    (folder / "w.yaml").write_text(WORLD)
    client = Client(str(folder / "w.yaml"), engine=engine)
    client.spawn("cube", Pose3D(Position3D(0.4, 0.0, 0.1 + EDGE / 2)), box(EDGE, EDGE, EDGE))
    return client


def move(client: Client, z: float, *, straight: bool = True) -> wire.Occurrence:
    request = wire.MoveToPose(
        id="m",
        robot="mine",
        pose=down(0.4, 0.0, z),
        frame="base_link",
        straight=straight,
        max_velocity_scaling_factor=0.3,
        may_touch=("cube",),
    )
    client.ask(wire.MOVE_TO_POSE, request)
    return client.run_until("m")[0]


def grip(client: Client, opening: float) -> wire.Occurrence:
    client.ask(wire.GRIPPER_COMMAND, wire.GripperCommand(id="g", robot="mine", opening=opening, tolerance=2e-3))
    return client.run_until("g")[0]


def opening_of(client: Client) -> float:
    return client.ask(wire.GET_ARM_STATE, wire.RobotName(robot="mine")).opening


def test_the_opening_of_turning_fingers_is_derived() -> None:
    found = gripper()
    assert found.joints == ("drive_joint", "right_outer_knuckle_joint")
    assert found.links == ("left_finger", "right_finger")
    # The maker states 84 mm; the solid shapes of the fingers are a little apart.
    assert found.stroke == pytest.approx(0.086, abs=0.004)
    assert found.turning is not None
    for opening in (0.01, 0.05, found.stroke):
        position = found.position_of(opening)
        assert found.opening_of(np.array([position, position])) == pytest.approx(opening, abs=1e-9)
    assert found.position_of(-0.02) > found.position_of(0.0)
    assert found.opening_speed(np.array([1.0, 1.0])) < 0.0


@pytest.mark.parametrize("openings", [(0.1, 0.1), (0.1, 0.0, 0.05), (0.1,)])
def test_openings_are_monotonic(openings: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="openings"):
        FingerMotion(positions=(0.0, 0.5, 0.8)[: max(2, len(openings))], openings=openings)


@pytest.mark.parametrize("engine", ENGINES)
def test_turning_fingers_pick_a_cube(tmp_path: Path, engine: str) -> None:
    client = start(tmp_path, engine)
    assert opening_of(client) == pytest.approx(gripper().stroke, abs=1e-3)
    for z, straight in ((0.4, False), (0.28, True)):
        ended = move(client, z, straight=straight)
        assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert grip(client, 0.0).outcome is Outcome.SUCCEEDED
    assert opening_of(client) == pytest.approx(EDGE, abs=4e-3)
    assert client.ask(wire.GET_ARM_STATE, wire.RobotName(robot="mine")).held == "cube"
    snapshot = save(client)
    ends = []
    for each in (client, Client("empty", 99, engine)):
        if each is not client:
            restore(each, snapshot)
        assert move(each, 0.4).outcome is Outcome.SUCCEEDED
        ends.append(each.simulator.simulation.engine.body_state("cube"))
    assert ends[0] == ends[1]
    assert ends[0].position[2] == pytest.approx(0.1 + EDGE / 2 + 0.12, abs=0.02)
    assert grip(client, 0.08).outcome is Outcome.SUCCEEDED
    assert client.ask(wire.GET_ARM_STATE, wire.RobotName(robot="mine")).held == ""
