"""Trajectories of a run: poses, commands and joints of robots and movable bodies, sampled over time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from sim_nodes.entities import Entities
from sim_nodes.geometry import Array, Pose2, roll_pitch_yaw
from sim_nodes.physics import BodyState, Engine
from sim_nodes.robots.kinematics import base_motion
from sim_nodes.robots.mobile import MobileBase
from sim_nodes.robots.robot import Robot
from sim_nodes.stateful import Stateful

SAMPLE_TICKS = 5  # between two samples: 10 Hz
MAX_ROWS = 100_000  # of each table; at the limit, every second sample is dropped
BLOCK = 256  # rows that are packed together

POSE_COLUMNS = (
    *("x", "y", "z", "roll", "pitch", "yaw"),
    *("believed_x", "believed_y", "believed_yaw", "odom_x", "odom_y", "odom_yaw"),
    *("command_linear", "command_lateral", "command_angular", "contact"),
)
"""Columns after time and entity [m], [rad], [m/s], [rad/s]; not a number without a value."""
JOINT_COLUMNS = ("position", "velocity", "effort")
"""Columns after time, robot and joint [rad, m], [rad/s, m/s], [N m, N]."""
UNKNOWN = (math.nan,) * 3


class Samples(Stateful):
    """A table of numbers with the tick and the subject of each row, of bounded size.

    A full table drops every second sample, and doubles its period.

    Args:
        width: Number of values in a row.
        limit: Maximum number of rows.
    """

    STATE = ("_subjects", "_blocks", "_open", "_count", "_every")

    def __init__(self, width: int, limit: int = MAX_ROWS) -> None:
        self._width, self._limit = width + 2, limit
        self._subjects: dict[str, int] = {}  # numbers by name
        self._blocks: list[bytes] = []  # full ones, which copies of the state share
        self._open = np.zeros((BLOCK, self._width))
        self._count = 0  # rows of the open block
        self._every = SAMPLE_TICKS

    def is_due(self, tick: int) -> bool:
        """Whether a tick is sampled."""
        return tick % self._every == 0

    def add(self, tick: int, name: str, values: tuple[float, ...]) -> None:
        """Add a row."""
        self._open[self._count] = (tick, self._subjects.setdefault(name, len(self._subjects)), *values)
        self._count += 1
        if self._count == BLOCK:
            self._blocks.append(self._open.tobytes())
            self._count = 0
            if len(self) >= self._limit:
                self._thin()

    def __len__(self) -> int:
        return len(self._blocks) * BLOCK + self._count

    def _thin(self) -> None:
        """Keep the samples of every second sampled tick."""
        rows = self._rows()
        self._every *= 2
        kept = rows[rows[:, 0] % self._every == 0]
        whole = len(kept) - len(kept) % BLOCK
        self._blocks = [kept[at : at + BLOCK].tobytes() for at in range(0, whole, BLOCK)]
        self._count = len(kept) - whole
        self._open[: self._count] = kept[whole:]

    def _rows(self) -> Array:
        blocks = [np.frombuffer(block).reshape(BLOCK, self._width) for block in self._blocks]
        return np.vstack([*blocks, self._open[: self._count]])

    def rows(self) -> Iterator[tuple[int, str, list[float]]]:
        """Yield tick, subject and values of each row, in the order in which they were added."""
        names = tuple(self._subjects)
        for tick, subject, *values in self._rows().tolist():
            yield int(tick), names[int(subject)], values


class Trajectories(Stateful):
    """Samples of all robots and movable bodies.

    Robots at rest, and bodies while all robots are at rest, are sampled once a second.

    Args:
        engine: Engine with the true states.
        robots: Robots by name.
        entities: Entities of the world.
        touches: Returns whether an entity is in contact.
        tick: Tick of the first sample.

    Attributes:
        poses: Samples of poses, with `POSE_COLUMNS`.
        joints: Samples of joints of arms and legs, with `JOINT_COLUMNS`; subjects are `robot/joint`.
    """

    STATE = ("poses", "joints", "_touched")

    def __init__(
        self,
        engine: Engine,
        robots: Mapping[str, Robot],
        entities: Entities,
        touches: Callable[[str], bool],
        tick: int,
    ) -> None:
        self._engine = engine
        self._entities = entities
        self._touches = touches
        self.poses = Samples(len(POSE_COLUMNS))
        self.joints = Samples(len(JOINT_COLUMNS))
        self._touched: set[str] = set()  # entities with a contact since their last sample
        for robot in robots.values():
            self._add_robot(robot, tick)
            self._add_joints(robot, tick)
        self._add_bodies(tick)

    def record_contact(self, first: str, second: str) -> None:
        """Record the begin of a contact of two entities."""
        self._touched.update((first, second))

    def record_robot(self, robot: Robot, tick: int) -> None:
        """Record a robot if the tick is sampled."""
        if tick % SAMPLE_TICKS:
            return
        if self.poses.is_due(tick):
            self._add_robot(robot, tick)
        if self.joints.is_due(tick):
            self._add_joints(robot, tick)

    def record_bodies(self, tick: int) -> None:
        """Record the movable bodies if the tick is sampled."""
        if self.poses.is_due(tick):
            self._add_bodies(tick)

    def _add_robot(self, robot: Robot, tick: int) -> None:
        base = robot.mobile if robot.drives else None
        self._add_pose(robot.name, () if base is None else _driven(base), tick)

    def _add_joints(self, robot: Robot, tick: int) -> None:
        if robot.declaration.arm is not None:
            arm = robot.arm
            states = arm.states()
            columns = (states.positions.tolist(), states.velocities.tolist(), states.efforts.tolist())
            for joint, *values in zip(arm.joints, *columns, strict=True):
                self.joints.add(tick, f"{robot.name}/{joint}", tuple(values))

    def _add_bodies(self, tick: int) -> None:
        for name in self._entities.movable():
            self._add_pose(name, (), tick)

    def _add_pose(self, name: str, driven: tuple[float, ...], tick: int) -> None:
        contact = float(name in self._touched or self._touches(name))
        self._touched.discard(name)
        beside = driven or 3 * UNKNOWN
        self.poses.add(tick, name, (*_pose(self._engine.body_state(name)), *beside, contact))


def _pose(state: BodyState) -> tuple[float, ...]:
    return (*state.position, *roll_pitch_yaw(state.orientation))


def _driven(base: MobileBase) -> tuple[float, ...]:
    """Return the believed pose, the odometry, and the command before faults of the motors."""
    linear, angular, lateral = base_motion(base.declaration.drive, base.wheels.command)
    return (*_planar(base.localised_pose()), *_planar(base.odometry.pose), linear, lateral, angular)


def _planar(pose: Pose2 | None) -> tuple[float, ...]:
    return UNKNOWN if pose is None else (pose.x, pose.y, pose.yaw)
