"""Implements `Engine` with PyBullet: robots, sensors and saved states of a scene.

The state for another process is saved as the calls that led to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import metadata
from typing import Any

import numpy as np
import pybullet

from sim_nodes.driven import upright_velocities, yaws
from sim_nodes.geometry import Array, Vector, rotation_matrix, vector
from sim_nodes.journal import journaled, replay
from sim_nodes.physics import (
    CarriedBody,
    JointStates,
    Overlap,
)
from sim_nodes.pybullet.bodies import STEPS_PER_SECOND, PybulletBodies
from sim_nodes.pybullet.camera import draw, measure
from sim_nodes.pybullet.model import (
    joint_load,
)
from sim_nodes.pybullet.rewinding import Checkpoint, LastStep
from sim_nodes.pybullet.stepping import RETRY
from sim_nodes.views import DepthImage, Picture, View


class PybulletEngine(PybulletBodies):
    """PyBullet with one scene; implements `sim_nodes.physics.Engine`."""

    name = "pybullet"
    version = metadata.version("pybullet")
    steps_per_second = STEPS_PER_SECOND

    def save(self) -> Mapping[str, Any]:
        """See `SavesState.save`."""
        return {"added": self._at_start, "work": self._work.done, **self.journal.save()}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """See `SavesState.restore`."""
        self._added = dict(saved["added"])
        self._load()
        replay(saved, self, partial(self._make_steps, self._stepper.repeat))
        self._resume_work(saved["work"])

    def checkpoint(self) -> Checkpoint | None:
        """See `Rewinds.checkpoint`."""
        mark = self.journal.mark()
        # Joints of bodies have motors for their friction, whose order depends on the past.
        has_joints = len(self._jointed) > len(self._arms)
        if mark is None or has_joints or self._broadphase.has_ambiguous_pair():
            return None
        return Checkpoint(
            self._states.save(),
            mark,
            {name: drive.command for name, drive in self._drives.items()},
            {name: arm.command for name, arm in self._arms.items()},
            LastStep(
                self.touching(),
                {name: self.contact_points(name) for name in self._links},
                {name: self.link_contacts(name) for name in self._arms},
                {name: self.joint_states(name).efforts for name in self._arms},
            ),
            self._work.done,
        )

    def rewind(self, checkpoint: Checkpoint) -> None:
        """See `Rewinds.rewind`."""
        self.journal.cut(checkpoint.mark)
        if self._stepper.has_diverged or not self._states.is_latest(checkpoint.saved):
            # Bullet removes bodies without a pose from its world for good.
            self.restore(self.save())
            return
        still = self._static - {self._bodies[name].number for name in self._arms}
        self._states.restore(checkpoint.saved, [number for number in self._owners if number not in still])
        for name, speeds in checkpoint.drives.items():
            self._drives[name].apply_command(speeds)
        for name, command in checkpoint.arms.items():
            self._arms[name].apply_command(command)
        self._body_states = {}
        self._resume_work(checkpoint.work)
        self._last = checkpoint.last
        self._stepper.touching = self._last.touching
        self._stepper.invalidate()

    def driven_poses(self) -> Array:
        """See `DrivesBodies.driven_poses`."""
        places, turns = self._driven_frames()
        return np.column_stack([places[:, :2], yaws(turns)])

    def drive_bodies(self, velocities: Array, heights: Array) -> None:
        """See `DrivesBodies.drive_bodies`."""
        self.set_driven_velocities(velocities.ravel(), heights)

    @journaled
    def set_driven_velocities(self, row: Array, heights: Array) -> None:
        """Set the velocities of `drive_bodies`, given as one row for the journal."""
        velocities = row.reshape(-1, 3)
        places, turns = self._driven_frames()
        falling = np.array([0.0 if self._added[name][0].built_in else 1.0 for name in self._driven])
        linear, angular = upright_velocities(velocities, heights - places[:, 2], turns, falling)
        for name, along, about in zip(self._driven, linear.tolist(), angular.tolist(), strict=True):
            pybullet.resetBaseVelocity(self._bodies[name].number, along, about, self._client)
        self._body_states = {}

    def _driven_frames(self) -> tuple[Array, Array]:
        """Return positions (n, 3) [m] and orientations (n, 4) of the driven bodies."""
        frames = [self._frame(self._bodies[name]) for name in self._driven]
        places = np.array([position for position, _, _ in frames]).reshape(-1, 3)
        return places, np.array([orientation for _, orientation, _ in frames]).reshape(-1, 4)

    @property
    def _driven(self) -> tuple[str, ...]:
        """Names of the driven bodies, in the order in which they were added."""
        return tuple(name for name, (model, _) in self._added.items() if model.driven)

    def wheel_angles(self, robot: str) -> tuple[float, ...]:
        """See `Engine.wheel_angles`."""
        return self._drives[robot].angles()

    def command_wheels(self, robot: str, *targets: float) -> None:
        """See `Engine.command_wheels`."""
        if targets != self._drives[robot].command.targets:  # in most ticks, the command repeats
            self.set_motor_targets(robot, *targets)

    @journaled
    def set_motor_targets(self, robot: str, *targets: float) -> None:
        """Set the targets of the motors of a drive."""
        drive = self._drives[robot]
        drive.apply_command(replace(drive.command, targets=targets))

    @journaled
    def power_wheels(self, robot: str, on: bool) -> None:
        """See `Engine.power_wheels`."""
        drive = self._drives[robot]
        drive.apply_command(replace(drive.command, has_power=on))

    def cast_rays(
        self, robot: str, link: str, directions: Array, limit: float, position: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        """See `Engine.cast_rays`."""
        place, orientation = self.link_pose(robot, link)
        turn = rotation_matrix(orientation)
        origin = np.add(place, turn @ position)
        return limit * self._rays.cast(robot, vector(origin), origin + limit * directions @ turn.T)

    def motor_work(self, robot: str) -> float:
        """See `MeasuresWork.motor_work`."""
        return self._work.total(robot)

    def measure_work(self, robot: str) -> None:
        """See `MeasuresWork.measure_work`."""
        self._work.measure(robot)
        self._sums[:] = [self._work]

    def joint_states(self, robot: str) -> JointStates:
        """See `Engine.joint_states`."""
        states = self._arms[robot].states()
        return states if self._last is None else replace(states, efforts=self._last.efforts[robot])

    @journaled
    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        """See `Engine.command_joints`."""
        self._arms[robot].command_joints(positions, velocities)
        self._stepper.invalidate(RETRY)  # motors may pull hard until they arrive

    @journaled
    def command_fingers(self, robot: str, position: float, force: float) -> None:
        """See `Engine.command_fingers`."""
        self._arms[robot].command_fingers(position, force)
        self._stepper.invalidate(RETRY)

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: CarriedBody | None
    ) -> tuple[Overlap, ...]:
        """See `Engine.arm_overlaps`."""
        load = "" if carried is None else carried.name
        shapes = [] if carried is None else self._placed_shapes.of(self._added[load][0], carried.state)
        others = {number: name for number, name in self._owners.items() if name not in (robot, load)}
        return tuple(self._arms[robot].overlaps(positions, others, own, load, shapes))

    def joint_load(self, robot: str, link: str) -> tuple[Vector, Vector]:
        """See `Engine.joint_load`."""
        return joint_load(self._bullet, self._bodies[robot].number, self._links[robot][link])

    def render_depth(self, view: View) -> DepthImage:
        """See `Engine.render_depth`."""
        return measure(self._bullet, view, self._owners)

    def render(self, view: View) -> Picture:
        """See `Engine.render`."""
        return draw(self._bullet, view, self._scene.light)
