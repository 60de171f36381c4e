"""Contracts of backends whose robots drive or have arms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from seoro.lang.frozen import Value
from seoro.robotics.geometry import Pose3D, Position3D, Velocity6D
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.people import Point


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

    async def drive(
        self,
        robot: str,
        linear: float,
        angular: float,
        duration: float,
        report: Reporter,
        lateral: float = 0.0,
    ) -> str:
        """Drive at a velocity for a duration [s], then stop; return the goal's id.

        `linear` [m/s] is ahead; `angular` [rad/s] and `lateral` [m/s] are to the left.
        """

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop. Goals that have ended are ignored."""


@runtime_checkable
class PathRobots(Protocol):
    """Robots driven along paths by their true poses."""

    async def follow_path(
        self, robot: str, points: Sequence[Point], speed: float, report: Reporter, *, repeat: bool
    ) -> str:
        """Drive along straight lines between points; return the goal's id.

        A `speed` [m/s] of 0 is the robot's maximum. With `repeat`, it starts again at the first point, without an
        end.
        """

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop. Goals that have ended are ignored."""


@runtime_checkable
class VelocityCommands(Protocol):
    """Robots that follow velocity commands of a topic."""

    async def command_velocity(self, topic: str, velocity: Velocity6D) -> None:
        """Publish a velocity command on a robot's topic `cmd_vel`; it is valid for 0.5 s at most."""


class MotionOptions(Value):
    """Options of an arm motion.

    `scaling` limits the speed, as a share of the maximum. `tolerance` applies to the goal of each joint [rad] or
    to the opening of the gripper [m]. The arm may collide with the entities in `may_touch`. `plan_only` plans and
    checks a motion without moving. `replan` plans again if a new obstacle blocks the path.
    """

    scaling: float = 1.0
    tolerance: float = 1e-3
    may_touch: tuple[str, ...] = ()
    plan_only: bool = False
    replan: bool = False


class ArmState(Value):
    """Pose of the tool in the map, opening of the gripper [m], and name of the held entity (empty: none)."""

    tool: Pose3D
    opening: float
    held: str


@runtime_checkable
class Arms(Protocol):
    """Arms with grippers. Unreachable and colliding goals are refused before anything moves."""

    async def move_joints(
        self,
        robot: str,
        positions: Sequence[float],
        names: Sequence[str],
        options: MotionOptions,
        report: Reporter,
    ) -> str:
        """Move the arm's joints to positions [rad]; return the goal's id. `names` gives their order."""

    async def move_tool(
        self, robot: str, pose: Pose3D, frame: str, options: MotionOptions, report: Reporter, *, straight: bool
    ) -> str:
        """Move the tool to a pose in a frame (`map` or `base_link`); return the goal's id."""

    async def move_gripper(
        self, robot: str, opening: float, force: float | None, options: MotionOptions, report: Reporter
    ) -> str:
        """Move the gripper to an opening [m] with a force per finger [N]; None is the default force.

        Closing succeeds if an object stops the fingers. Return the goal's id.
        """

    async def hold_entity(self, robot: str, entity: str, duration: float, report: Reporter) -> str:
        """Report when the gripper has held an entity for a duration [s] or dropped it; return the goal's id."""

    async def watch_joint(
        self, robot: str, joint: str, position: float, tolerance: float, report: Reporter
    ) -> str:
        """Report when a joint is near a position [rad, m] or has passed it; return the watch's id."""

    async def arm_state(self, robot: str) -> ArmState:
        """Return the state of the arm."""

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop the motion. Goals that have ended are ignored."""

    async def cancel_watch(self, watch: str) -> None:
        """Cancel a watch. Watches that have fired are ignored."""


@runtime_checkable
class Postures(Protocol):
    """Robots with named postures."""

    async def take_posture(self, robot: str, posture: str, options: MotionOptions, report: Reporter) -> str:
        """Move the joints to a posture that the robot declares; return the goal's id."""

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop the motion. Goals that have ended are ignored."""
