"""What a backend may be able to do, by protocol: an action names the one that it needs of where its actor lives.

Units are SI, angles radians; poses are in the frame `map` unless a parameter says otherwise. What all of their
methods have in common stands with `contracts.Backend`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from seoro.runtime.contracts import Pose3D, Position3D, Reporter, Velocity6D


@runtime_checkable
class MobileRobots(Protocol):
    """Robots that drive. `robot` is what `home_of` returned."""

    async def set_initial_pose(self, robot: str, pose: Pose3D) -> None:
        """Tell the robot's localisation where it is."""
        ...

    async def navigate(self, robot: str, poses: Sequence[Pose3D], *, stop_at_each: bool, report: Reporter) -> str:
        """Drive through poses; returns the goal's id when the robot has accepted it."""
        ...

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop; a goal that has ended by itself is left alone."""
        ...

    async def watch_proximity(
        self, frame: str, parent_frame: str, point: Position3D, threshold: float, report: Reporter
    ) -> str:
        """Report when a frame is within `threshold` [m] of a point, in the plane; returns the watch's id."""
        ...

    async def watch_distance(self, robot: str, distance: float, report: Reporter) -> str:
        """Report when the robot's odometry has counted `distance` [m] from now on; returns the watch's id."""
        ...

    async def cancel_watch(self, watch: str) -> None:
        """Forget a watch; one that has fired is left alone."""
        ...


@runtime_checkable
class DrivenRobots(Protocol):
    """Robots that are driven by velocities, without knowing where they are."""

    async def drive(self, robot: str, linear: float, angular: float, duration: float, report: Reporter) -> str:
        """Drive ahead [m/s] and turn to the left [rad/s] for a duration [s], and stop; returns the goal's id."""
        ...

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop; a goal that has ended by itself is left alone."""
        ...

    async def command_velocity(self, topic: str, velocity: Velocity6D) -> None:
        """Publish a command of velocity on the topic `cmd_vel` of a robot, which obeys it for 0.5 s at most."""
        ...


@runtime_checkable
class Simulation(Protocol):
    """A simulated world; terms of ROS `simulation_interfaces`."""

    async def spawn_entity(self, name: str, model: str, pose: Pose3D, *, allow_renaming: bool = False) -> str:
        """Spawn a model, found along the model path; returns the name it got."""
        ...

    async def relative_pose(self, frame: str, parent_frame: str, distance: float) -> Pose3D:
        """The pose `distance` [m] ahead of a frame, in the parent frame."""
        ...

    async def delete_entity(self, name: str) -> None:
        """Delete an entity."""
        ...

    async def entities(self) -> tuple[str, ...]:
        """Names of all entities."""
        ...

    async def set_entity_state(self, name: str, pose: Pose3D, velocity: Velocity6D) -> None:
        """Put an entity somewhere, with a velocity."""
        ...

    async def step_simulation(self, steps: int) -> None:
        """Make physics steps while paused."""
        ...

    async def reset_simulation(self) -> None:
        """Put every entity back to its initial state, and delete what was spawned; time goes on."""
        ...
