"""Wheel odometry: where a robot believes to be by what its wheels have turned, with errors that add up."""

from __future__ import annotations

import math

from sim_nodes.geometry import Pose2, wrap
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import DriveDeclaration, OdometryDeclaration
from sim_nodes.robots.diff_drive import Velocity, base_motion
from sim_nodes.stateful import Stateful

STILL = 1e-5  # [m], [rad]; less motion than this in a tick is rest, and rest has no errors


class Odometry(Stateful):
    """The odometry of a differential drive; it starts at the origin of the frame `odom`.

    Attributes:
        pose: Pose of the base in `odom`.
        travelled: Length of the path so far [m].
        velocity: Velocity of the base over the last tick by the wheels alone, without the errors of slip.
    """

    STATE = ("_angles", "pose", "travelled", "velocity")

    def __init__(self, drive: DriveDeclaration, declaration: OdometryDeclaration, noise: Noise) -> None:
        self._drive = drive
        self._declaration = declaration
        self._noise = noise
        self._angles: tuple[float, float] | None = None
        self.pose = Pose2(0.0, 0.0, 0.0)
        self.travelled = 0.0
        self.velocity = Velocity(0.0, 0.0)

    def update(self, angles: tuple[float, float], interval: float, tick: int) -> None:
        """Take in the wheels' angles [rad], `interval` seconds after the last ones."""
        last, self._angles = self._angles or angles, angles
        distance, turn = base_motion(self._drive, angles[0] - last[0], angles[1] - last[1])
        self.velocity = Velocity(distance / interval, turn / interval)
        if abs(distance) > STILL or abs(turn) > STILL:
            distance, turn = self._disturbed(distance, turn, tick)
        x, y, yaw = self.pose
        middle = yaw + turn / 2.0
        self.pose = Pose2(x + distance * math.cos(middle), y + distance * math.sin(middle), wrap(yaw + turn))
        self.travelled += abs(distance)

    def _disturbed(self, distance: float, turn: float, tick: int) -> tuple[float, float]:
        errors = self._declaration
        a, b, c = self._noise.at(tick).standard_normal(3).tolist()
        way = math.sqrt(abs(distance))
        return (
            distance + a * errors.distance_noise * way,
            turn + b * errors.turn_noise * math.sqrt(abs(turn)) + c * errors.drift_noise * way,
        )
