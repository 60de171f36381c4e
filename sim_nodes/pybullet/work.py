"""Mechanical work of the motors of robots in PyBullet.

Reading the torques takes a tenth of a step. They are read in each step for measured robots only, and sampled at
50 Hz for other robots under command. Planar drives know the forces on their base anyway.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import pybullet

from seoro.deferred import dataclass
from sim_nodes.pybullet.planar import BaseWork, PlanarForces

SAMPLE_STEPS = 4  # between two samples


class Motors(NamedTuple):
    """The motors of a robot.

    Attributes:
        body: Number of its body.
        joints: Numbers of the joints with motors.
        base: The forces of a planar drive.
        is_commanded: Returns whether a command moves them.
    """

    body: int
    joints: tuple[int, ...]
    base: PlanarForces | None
    is_commanded: Callable[[], bool]


@dataclass(frozen=True)
class WorkDone:
    """Work of motors up to a step.

    Attributes:
        totals: Work of joints by robot [J].
        bases: Work on the bases of planar drives by robot.
        measured: Robots that are measured in each step.
        steps: Number of steps since the last sample.
    """

    totals: Mapping[str, float]
    bases: Mapping[str, BaseWork]
    measured: frozenset[str]
    steps: int


class MotorWork:
    """Sums the work of motors.

    Args:
        client: Number of the connection.
        timestep: Length of a step [s].
        motors: Motors by robot.
    """

    def __init__(self, client: int, timestep: float, motors: Mapping[str, Motors]) -> None:
        self._client, self._timestep, self._motors = client, timestep, motors
        self._totals = dict.fromkeys(motors, 0.0)
        self._speeds: dict[str, list[float]] = {}  # of the joints of measured robots, before the next step
        self._steps = 0

    @property
    def done(self) -> WorkDone:
        """The present sums."""
        bases = {name: motors.base.done for name, motors in self._motors.items() if motors.base is not None}
        return WorkDone(dict(self._totals), bases, frozenset(self._speeds), self._steps)

    def resume(self, done: WorkDone) -> None:
        """Continue from sums that belong to a restored state of Bullet."""
        self._totals, self._steps = dict(done.totals), done.steps
        for name, base in done.bases.items():
            forces = self._motors[name].base
            assert forces is not None, "the scene is the same"
            forces.done = base
        self._speeds = {robot: [] for robot in sorted(done.measured)}
        self.read_speeds()

    def total(self, robot: str) -> float:
        """Return the work of a robot's motors [J]."""
        base = self._motors[robot].base
        return self._totals[robot] + (0.0 if base is None else base.done.total)

    def measure(self, robot: str) -> None:
        """Measure a robot in each step from now on."""
        self._speeds.setdefault(robot, [])
        self.read_speeds()

    def read_speeds(self) -> None:
        """Read the speeds of joints anew, because they were set."""
        for robot in self._speeds:
            self._speeds[robot] = [state[1] for state in self._states(robot)]

    def add_step(self) -> None:
        """Add the step that was made."""
        for robot, before in self._speeds.items():
            states = self._states(robot)
            after = [state[1] for state in states]
            powers = [max(0.0, state[3] * (v + w)) for state, v, w in zip(states, before, after, strict=True)]
            self._totals[robot] += sum(powers) * self._timestep / 2.0
            self._speeds[robot] = after

    def sample(self, steps: int) -> None:
        """Sample robots that are not measured, if it is time after some more steps."""
        self._steps += steps
        if self._steps < SAMPLE_STEPS:
            return
        self._steps %= SAMPLE_STEPS
        for robot, motors in self._motors.items():
            if robot not in self._speeds and motors.is_commanded():
                power = sum(max(0.0, state[1] * state[3]) for state in self._states(robot))
                self._totals[robot] += power * SAMPLE_STEPS * self._timestep

    def _states(self, robot: str) -> tuple[tuple[float, ...], ...]:
        motors = self._motors[robot]
        states: tuple[tuple[float, ...], ...] = pybullet.getJointStates(motors.body, motors.joints, self._client)
        return states
