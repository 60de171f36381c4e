"""What a backend may be able to do, by protocol: an action names the one that it needs of where its actor lives.

Units are SI, angles radians; poses are in the frame `map` unless a parameter says otherwise. What all of their
methods have in common stands with `contracts.Backend`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

from seoro.lang.frozen import Value
from seoro.runtime.contracts import Pose3D, Position3D, Reporter, Velocity6D
from seoro.runtime.device_faults import Fault


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
        self, robot: str, frame: str, parent_frame: str, point: Position3D, threshold: float, report: Reporter
    ) -> str:
        """Report when a frame is within `threshold` [m] of a point, in the plane; returns the watch's id.

        Frames that each robot has, such as `base_link`, are the robot's own.
        """
        ...

    async def watch_distance(self, robot: str, distance: float, report: Reporter) -> str:
        """Report when the robot's odometry has counted `distance` [m] from now on; returns the watch's id."""
        ...

    async def cancel_watch(self, watch: str) -> None:
        """Forget a watch; one that has fired is left alone."""
        ...


@runtime_checkable
class LocalisedRobots(Protocol):
    """Robots that find out where they are on a map."""

    async def reinitialize_global_localization(self, robot: str) -> None:
        """Have a robot forget where it is, and look for itself on the whole map."""
        ...

    async def watch_localization(self, robot: str, report: Reporter) -> str:
        """Report when a robot knows where it is; returns the watch's id."""
        ...

    async def cancel_watch(self, watch: str) -> None:
        """Forget a watch; one that has fired is left alone."""
        ...

    async def localization_error(self, robot: str) -> float | None:
        """How far a robot is from where it believes to be [m]; None when it does not know where it is."""
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
class Connected(Protocol):
    """A backend whose connection may be lost for a while, so that what is waited for does not come."""

    def loss_since(self, moment: float) -> str:
        """Return why something may have been missed since a moment; empty if nothing can have been.

        Args:
            moment: The moment, by `time.monotonic` [s].
        """
        ...


@runtime_checkable
class ContactSensing(Protocol):
    """Robots whose contacts are reported as `contact`, with what a `contracts.Contact` has."""

    def senses_contacts(self, robot: str) -> bool:
        """Whether those of a robot are, all of them and with who moved into whom."""
        ...


class Manner(Value):
    """How an arm is to move.

    `scaling` is the part of its speed that it may use, `tolerance` how near its joints have to come to their goal
    [rad], or the gripper to its opening [m]; `may_touch` are entities that it may collide with. With `plan_only` a
    motion is found and checked, and nothing moves; with `replan` another is looked for when something new is in
    the way of the first.
    """

    scaling: float = 1.0
    tolerance: float = 1e-3
    may_touch: tuple[str, ...] = ()
    plan_only: bool = False
    replan: bool = False


class ArmState(Value):
    """The pose of a tool in the map, the opening of the gripper [m], and what that holds; empty for nothing."""

    tool: Pose3D
    opening: float
    held: str


@runtime_checkable
class Arms(Protocol):
    """Arms with grippers. What is out of reach or would collide is refused before anything moves."""

    async def move_joints(
        self, robot: str, positions: Sequence[float], names: Sequence[str], manner: Manner, report: Reporter
    ) -> str:
        """Move the arm's joints to positions [rad], in the order of `names` or its own; returns the goal's id."""
        ...

    async def move_tool(
        self, robot: str, pose: Pose3D, frame: str, manner: Manner, report: Reporter, *, straight: bool
    ) -> str:
        """Move the tool to a pose in a frame, `map` or `base_link`; returns the goal's id."""
        ...

    async def move_gripper(
        self, robot: str, opening: float, force: float | None, manner: Manner, report: Reporter
    ) -> str:
        """Open or close the gripper to an opening [m] with a force of each finger [N], None for its usual one.

        Closing fingers that are stopped by something have succeeded. Returns the goal's id.
        """
        ...

    async def hold_entity(self, robot: str, entity: str, duration: float, report: Reporter) -> str:
        """Report when the gripper has held an entity for a duration [s], or has lost it; returns the goal's id."""
        ...

    async def watch_joint(
        self, robot: str, joint: str, position: float, tolerance: float, report: Reporter
    ) -> str:
        """Report when a joint is near a position [rad, m] or has passed it; returns the watch's id."""
        ...

    async def arm_state(self, robot: str) -> ArmState:
        """Where the tool is, and what it holds."""
        ...

    async def cancel_goal(self, goal: str) -> None:
        """Cancel a goal and stop; a goal that has ended by itself is left alone."""
        ...

    async def cancel_watch(self, watch: str) -> None:
        """Forget a watch; one that has fired is left alone."""
        ...


@runtime_checkable
class Simulation(Protocol):
    """A simulated world; terms of ROS `simulation_interfaces`."""

    async def spawn_entity(self, name: str, model: str, pose: Pose3D, *, allow_renaming: bool = False) -> str:
        """Spawn a model, found along the model path; returns the name it got."""
        ...

    async def spawn_entities(self, entities: Sequence[tuple[str, str, Pose3D]]) -> None:
        """Spawn several, each by its name, its model and its place, in their order; those that can be, are."""
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


@runtime_checkable
class Worlds(Protocol):
    """A simulator with more than one world."""

    async def change_world(self, world: str) -> None:
        """Go on in another world, at its initial state, by its name or the path of its file.

        The time of the run goes on. Goals that are active end as canceled; watches go on, and wait for what the
        world does not have. What was spawned is gone, and robots know nothing any more. A world without a robot
        that an actor of the run lives as is refused.
        """
        ...


class Image(Value):
    """A picture: when it was taken [s], its size [pixels], and itself as PNG."""

    time: float
    width: int
    height: int
    png: bytes


@runtime_checkable
class Cameras(Protocol):
    """Cameras. Free ones can be moved; those that a robot carries are called `robot/camera`."""

    async def spawn_camera(self, name: str, pose: Pose3D, fov: float, width: int, height: int) -> str:
        """Spawn a free camera, which looks along the x axis of its pose; returns the name it got.

        Args:
            name: Its name.
            pose: Where it is.
            fov: Vertical field of view [rad].
            width: Of its pictures [pixels].
            height: Of its pictures [pixels].
        """
        ...

    async def cameras(self) -> tuple[str, ...]:
        """Names of all cameras."""
        ...

    async def place_camera(self, name: str, pose: Pose3D) -> None:
        """Put a free camera somewhere; it follows nothing any more."""
        ...

    async def aim_camera(self, name: str, target: Position3D) -> None:
        """Turn a free camera where it is, so that a point is in the middle of its pictures."""
        ...

    async def follow_entity(self, name: str, entity: str, offset: Position3D) -> None:
        """Let a free camera go with an entity, at an offset along the axes of the map, and look at it."""
        ...

    async def delete_camera(self, name: str) -> None:
        """Delete a camera that was spawned."""
        ...

    async def take_picture(self, name: str) -> Image:
        """What a camera gives now; with its faults, by which it may also give nothing, and that is refused."""


@runtime_checkable
class Sensors(Protocol):
    """Sensors of robots. `robot` is what `home_of` returned, a sensor one of those of the robot.

    What is watched is what arrives from them, with the faults that they have. Each returns the watch's id.
    """

    async def watch_sample(self, robot: str, sensor: str, report: Reporter) -> str:
        """Report when the next sample arrives."""
        ...

    async def watch_bumper(self, robot: str, zone: str, entity: str, report: Reporter) -> str:
        """Report when a zone of the bumper is pressed by an entity; empty names are any."""
        ...

    async def watch_range(
        self, robot: str, sensor: str, distance: float, start: float, end: float, report: Reporter
    ) -> str:
        """Report when a lidar sees something nearer than `distance` [m] from one bearing to another [rad]."""
        ...

    async def check_rate(
        self, robot: str, sensor: str, lowest: float, highest: float, duration: float, report: Reporter
    ) -> str:
        """Report after `duration` [s] whether samples arrived at a rate within bounds [1/s]."""
        ...

    async def cancel_sensor_watch(self, watch: str) -> None:
        """Forget a watch; one that has fired is left alone."""
        ...


@runtime_checkable
class Faults(Protocol):
    """Faults of sensors, cameras and motors.

    `robot` is what `home_of` returned, a device one of those of the robot. Free cameras are devices of no robot,
    whose name is empty then.
    """

    def devices(self) -> Mapping[str, Sequence[str]]:
        """For each robot, in their order, the names of its devices."""
        ...

    async def inject_fault(self, robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        """Inject a fault, in the place of another of its kind, and measure that it takes effect.

        What was measured is reported: as a success, or, when the effect has not been found within `limit` [s], as
        abortion, and then the fault is cleared. Returns the id of the measurement.
        """
        ...

    async def cancel_fault(self, measurement: str) -> None:
        """Clear a fault that is being measured; one whose measurement has ended is left alone."""
        ...

    async def clear_faults(self, robot: str, device: str, fault: type[Fault] | None = None) -> None:
        """Clear the faults of a device, of one kind if one is given; of all devices if `device` is empty."""
        ...


@runtime_checkable
class Snapshots(Protocol):
    """A simulated world whose whole state can be saved during a run, and gone back to."""

    async def save_snapshot(self, name: str) -> None:
        """Save everything under a name; what was saved under it before is forgotten."""
        ...

    async def restore_snapshot(self, name: str, seed: int | None) -> None:
        """Go back to what was saved under a name in this run.

        The time of the run goes on. Goals that are active now and were active then go on, others end as canceled;
        what else robots did then they go on with, until they are told something else. Watches stay.

        Args:
            name: The name.
            seed: Of what is drawn from there on; None for what was drawn then.
        """
        ...
