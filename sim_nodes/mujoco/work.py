"""Mechanical work of the motors of robots in MuJoCo.

Sensors keep forces and speeds of the last steps, so nothing is read between two steps. MuJoCo integrates the
damping of motors implicitly. A motor with force `f` and gain `b` of speed (`biasprm[2]`) acts with `f + b (w - v)`
in a step from speed `v` to `w`, unless its force is at a limit. Its work is this force times the mean speed times
the time step, which agrees with the kinetic energy to rounding.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import mujoco
import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array

BATCH = 50  # maximum steps between two readings
KEPT = BATCH + 1  # values that sensors keep: the last one is read again with its successor
FORCE, SPEED = "#work/force", "#work/speed"  # suffixes of the sensors of a motor
HEADER = 2  # numbers before the times of a sensor's ring; the second is the index of the last value


def add_work_sensors(spec: Any) -> None:
    """Add sensors of force and speed for all motors to a specification."""
    types, objects = mujoco.mjtSensor, mujoco.mjtObj
    for motor in spec.actuators:
        if motor.trntype == mujoco.mjtTrn.mjTRN_JOINT:
            # Unlike that of a motor, the force on a joint includes its compensation of gravity.
            kind, name, force, speed = (
                objects.mjOBJ_JOINT,
                motor.target,
                types.mjSENS_JOINTACTFRC,
                types.mjSENS_JOINTVEL,
            )
        else:
            kind, name = objects.mjOBJ_ACTUATOR, motor.name
            force, speed = types.mjSENS_ACTUATORFRC, types.mjSENS_ACTUATORVEL
        for suffix, sensor in ((FORCE, force), (SPEED, speed)):
            spec.add_sensor(name=motor.name + suffix, type=sensor, objtype=kind, objname=name, nsample=KEPT)


@dataclass(frozen=True)
class WorkDone:
    """Work of motors up to a step.

    Attributes:
        totals: Work by robot [J].
        unread: Number of the last steps without theirs.
    """

    totals: Mapping[str, float]
    unread: int


class MotorWork:
    """Sums the work of motors, including each step when its successor has begun.

    Args:
        model: The model, with the sensors of `add_work_sensors`.
        data: Its data.
        robots: Names of the robots.
    """

    def __init__(self, model: Any, data: Any, robots: Iterable[str]) -> None:
        self._model, self._half = model, model.opt.timestep / 2.0
        names = {motor: model.actuator(motor).name for motor in range(model.nu)}
        motors = {robot: [at for at, name in names.items() if name.startswith(f"{robot}/")] for robot in robots}
        self._motors = [motor for several in motors.values() for motor in several]
        self._forces, self._speeds = (
            [_ring(model, data, names[motor] + suffix) for motor in self._motors] for suffix in (FORCE, SPEED)
        )
        self._joint_limits = np.array([_joint_limit(model, motor) for motor in self._motors])
        self._on_base = [bool(model.actuator_trntype[motor] == mujoco.mjtTrn.mjTRN_SITE) for motor in self._motors]
        gears = np.where(self._on_base, 1.0, model.actuator_gear[self._motors, 0])
        self._gears = np.abs(gears)  # forces and speeds of joints by those of their motors
        ends = np.cumsum([len(several) for several in motors.values()]).tolist()
        self._rows = {robot: range(end - len(motors[robot]), end) for robot, end in zip(motors, ends, strict=True)}
        self._totals = dict.fromkeys(motors, 0.0)
        self._unread = 0

    @property
    def done(self) -> WorkDone:
        """The present sums."""
        return WorkDone(dict(self._totals), self._unread)

    def resume(self, done: WorkDone) -> None:
        """Continue from sums that belong to a restored state of MuJoCo."""
        self._totals, self._unread = dict(done.totals), done.unread

    def total(self, robot: str) -> float:
        """Return the work of a robot's motors up to the step before the last [J]."""
        self.read()
        return self._totals[robot]

    def make_room(self, steps: int) -> None:
        """Read what up to `BATCH` further steps may overwrite."""
        if self._unread + steps > KEPT:
            self.read()

    def count(self, steps: int) -> None:
        """Count steps that were made."""
        self._unread += steps

    def read(self) -> None:
        """Add the steps up to the one before the last; do so before gains or limits of motors change."""
        count = self._unread
        if count < 2 or not self._motors:
            return
        self._unread = 1
        last = int(self._forces[0][1])
        kept = HEADER + KEPT + np.arange(last - count + 1, last + 1) % KEPT
        forces = np.array([ring[kept[:-1]] for ring in self._forces])
        speeds = np.array([ring[kept] for ring in self._speeds])
        before, after = speeds[:, :-1], speeds[:, 1:]
        gains = (self._gears**2 * self._model.actuator_biasprm[self._motors, 2]).reshape(-1, 1)
        mean = forces + np.where(np.abs(forces) < self._limits(), gains * (after - before), 0.0)
        work = mean * (before + after) * self._half
        for robot, rows in self._rows.items():
            self._totals[robot] = _added(self._totals[robot], self._delivered(work, rows, count - 1))

    def _limits(self) -> Array:
        """Return the forces at which motors are limited, shape (n, 1) [N], [N m]."""
        limited = self._model.actuator_forcelimited[self._motors].astype(bool)
        own = np.where(limited, self._gears * self._model.actuator_forcerange[self._motors, 1], np.inf)
        limits: Array = np.minimum(own, self._joint_limits).reshape(-1, 1)
        return limits

    def _delivered(self, work: Array, rows: range, steps: int) -> Array:
        """Return the work of a robot in each step [J]: motors that brake count as 0, those of the base as one."""
        delivered, base = np.zeros(steps), np.zeros(steps)
        for row in rows:
            if self._on_base[row]:
                base += work[row]
            else:
                delivered += np.maximum(work[row], 0.0)
        return delivered + np.maximum(base, 0.0)


def _added(total: float, steps: Array) -> float:
    """Add the work of steps in their order: the bits do not depend on how many are read at once."""
    for work in steps.tolist():
        total += work
    return total


def _ring(model: Any, data: Any, sensor: str) -> Array:
    """Return the memory of a sensor: header, times, and values."""
    start = model.sensor_historyadr[model.sensor(sensor).id]
    ring: Array = data.history[start : start + HEADER + 2 * KEPT]
    return ring


def _joint_limit(model: Any, motor: int) -> float:
    """Return the limit of the force on the joint of a motor [N], [N m]."""
    joint = model.actuator_trnid[motor, 0]
    on_joint = model.actuator_trntype[motor] == mujoco.mjtTrn.mjTRN_JOINT
    return float(model.jnt_actfrcrange[joint, 1]) if on_joint and model.jnt_actfrclimited[joint] else np.inf
