"""Client of an arm in its cell, and bodies for its table."""

from __future__ import annotations

import math
from importlib import resources
from typing import Any

from seoro.bridges import wire
from seoro.bridges.wire import Occurrence, Orientation3D, Outcome, Pose3D, Position3D
from tests.sim_nodes.client import Client

ARM = "ur10e"
TABLE = 0.7  # [m]; the height of the base, too
CUBE = resources.files("seoro").joinpath("models/manipulation/cube.sdf").read_text(encoding="utf-8")
HOME = (0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0)


def box(x: float, y: float, z: float, *, static: bool = False) -> str:
    """Return an SDF box with its origin at its centre."""
    return f"""<sdf version="1.9"><model name="box"><static>{str(static).lower()}</static><link name="link">
        <inertial><mass>0.2</mass></inertial>
        <collision name="collision"><geometry><box><size>{x} {y} {z}</size></box></geometry></collision>
        </link></model></sdf>"""


def down(x: float, y: float, z: float, yaw: float = 0.0) -> Pose3D:
    """Return the pose of a tool that points down."""
    return Pose3D(Position3D(x, y, z), Orientation3D(roll=math.pi, yaw=yaw))


class Cell(Client):
    """Client of a simulator with an arm in a cell; poses are in the frame of the arm's base."""

    def __init__(self, engine: str = "mujoco", seed: int = 0) -> None:
        super().__init__("arm_cell", seed, engine)
        self._goals = 0

    @property
    def now(self) -> float:
        return self.simulator.simulation.time

    @property
    def joints(self) -> wire.JointStates:
        return self.ask(wire.GET_JOINT_STATES, wire.RobotName(robot=ARM))

    @property
    def state(self) -> wire.ArmState:
        return self.ask(wire.GET_ARM_STATE, wire.RobotName(robot=ARM))

    def place(self, name: str, x: float, y: float, z: float, yaw: float = 0.0) -> tuple[float, float, float]:
        """Place an entity at a position in the frame of the arm's base; returns its position."""
        pose = Pose3D(Position3D(x, y, TABLE + z), Orientation3D(yaw=yaw))
        self.spawn(name, pose, CUBE)
        return self.where(name)

    def where(self, name: str) -> tuple[float, float, float]:
        """Return the position of an entity in the frame of the arm's base."""
        position = self.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=name)).pose.position
        return position.x, position.y, position.z - TABLE

    def start_joints(self, *points: tuple[float, ...], goal: str = "move", **more: Any) -> None:
        request = wire.FollowJointTrajectory(id=goal, robot=ARM, points=points, **more)
        self.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)

    def start_tool(self, pose: Pose3D, goal: str = "move", frame: str = "base_link", **more: Any) -> None:
        self.ask(wire.MOVE_TO_POSE, wire.MoveToPose(id=goal, robot=ARM, pose=pose, frame=frame, **more))

    def start_gripper(self, opening: float, goal: str = "grip", **more: Any) -> None:
        self.ask(wire.GRIPPER_COMMAND, wire.GripperCommand(id=goal, robot=ARM, opening=opening, **more))

    def end(self, goal: str = "move", limit: float = 30.0) -> Occurrence:
        return self.run_until(goal, self.now + limit)[0]

    def move(self, pose: Pose3D, *, straight: bool = False) -> None:
        """Move the tool and expect it to succeed."""
        self.start_tool(pose, straight=straight)
        ended = self.end()
        assert ended.outcome is Outcome.SUCCEEDED, ended.message

    def grip(self, opening: float = 0.0, **more: Any) -> None:
        """Move the fingers and expect that to succeed."""
        self.start_gripper(opening, **more)
        ended = self.end("grip")
        assert ended.outcome is Outcome.SUCCEEDED, ended.message

    def pick(self, name: str, x: float, y: float, yaw: float, **more: Any) -> None:
        """Pick a cube that stands on the table, and lift it by 15 cm."""
        self.move(down(x, y, 0.18, yaw))
        self.move(down(x, y, 0.03, yaw), straight=True)
        self.grip(**more)
        assert self.state.held == name
        self.move(down(x, y, 0.18, yaw), straight=True)
