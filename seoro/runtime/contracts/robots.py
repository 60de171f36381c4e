"""Contracts of backends whose robots drive."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from seoro.robotics.geometry import Pose3D, Position3D, Velocity6D
from seoro.runtime.contracts.backends import Reporter


@runtime_checkable
class MobileRobots(Protocol):
    """Robots that navigate. `robot` is the name from `assign_robot`."""

    async def set_initial_pose(self, robot: str, pose: Pose3D) -> None:
        """Set the pose of the robot's localization."""

    async def navigate(self, robot: str, poses: Sequence[Pose3D], *, stop_at_each: bool, report: Reporter) -> str:
        """Drive through poses; return the goal's id when the robot has accepted it."""

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop. Goals that have ended are ignored."""

    async def watch_proximity(
        self, robot: str, frame: str, parent_frame: str, point: Position3D, threshold: float, report: Reporter
    ) -> str:
        """Report when a frame is within `threshold` [m] of a point, in the plane; return the watch's id.

        Frames that every robot has, such as `base_link`, are those of this robot.
        """

    async def watch_distance(self, robot: str, distance: float, report: Reporter) -> str:
        """Report when the odometry has counted `distance` [m] from now on; return the watch's id."""

    async def cancel_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""


@runtime_checkable
class LocalisedRobots(Protocol):
    """Robots that localize themselves on a map."""

    async def reinitialize_global_localization(self, robot: str) -> None:
        """Discard the robot's pose estimate and search the whole map."""

    async def watch_localization(self, robot: str, report: Reporter) -> str:
        """Report when the robot has localized itself; return the watch's id."""

    async def cancel_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""

    async def localization_error(self, robot: str) -> float | None:
        """Return the error of the estimated position [m]; None if the robot is not localized."""


@runtime_checkable
class DrivenRobots(Protocol):
    """Robots driven by velocity commands, without localization."""

    async def drive(self, robot: str, linear: float, angular: float, duration: float, report: Reporter) -> str:
        """Drive at `linear` [m/s] and `angular` [rad/s] for a duration [s], then stop; return the goal's id."""

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop. Goals that have ended are ignored."""

    async def command_velocity(self, topic: str, velocity: Velocity6D) -> None:
        """Publish a velocity command on a robot's topic `cmd_vel`; it is valid for 0.5 s at most."""
