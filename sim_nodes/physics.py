"""What an engine must offer, and the data that it is given and gives back.

The core in `simulation.py` knows an engine by the `Engine` protocol only; `check` measures whether one keeps it.
Poses and velocities are in the world's frame `map`, SI units, orientations as quaternions (w, x, y, z).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from sim_nodes.colours import Colour
from sim_nodes.geometry import Array, Pose2, Quaternion, Vector, quaternion, yaw_of
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.views import Picture, View

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)
FLOOR = "floor"
DROP = 0.001  # [m] above the floor at which robots start, so that they do not start inside it
OVERLAP = 1e-3  # [m] of interpenetration that contacts at rest may have


@dataclass(frozen=True)
class Box:
    """A box by its edge lengths [m]."""

    size: Vector


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z [m]."""

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere [m]."""

    radius: float


Shape = Box | Cylinder | Sphere


@dataclass(frozen=True)
class Part:
    """A shape at a place in its body; without a mass [kg] of its own, it has its part of the body's by volume."""

    shape: Shape
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = IDENTITY
    mass: float | None = None


@dataclass(frozen=True)
class BodyModel:
    """A rigid body: its parts, its mass [kg] and the sliding friction of its surface.

    All of its parts have masses of their own, or none. What friction two surfaces have with one another is the
    engine's.
    """

    parts: tuple[Part, ...]
    mass: float = 1.0
    friction: float = 1.0
    static: bool = False  # immovable by forces; it may still be put elsewhere
    colour: Colour | None = None  # in pictures; None for one that follows from its name


@dataclass(frozen=True)
class BodyState:
    """Where a body is and how it moves: linear [m/s] and angular [rad/s] velocity of its origin."""

    position: Vector
    orientation: Quaternion = IDENTITY
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)

    @property
    def planar(self) -> Pose2:
        """The pose seen from above."""
        return Pose2(self.position[0], self.position[1], yaw_of(self.orientation))


@dataclass(frozen=True)
class Wall:
    """A standing box of the world; walls of the same name are one entity."""

    name: str
    x: float  # centre [m]
    y: float
    yaw: float
    length: float  # along its own x [m]
    thickness: float
    height: float

    @property
    def part(self) -> Part:
        """It as a part of a body at the origin of the map."""
        size = (self.length, self.thickness, self.height)
        return Part(Box(size), (self.x, self.y, self.height / 2), quaternion(0.0, 0.0, self.yaw))


@dataclass(frozen=True)
class PlacedRobot:
    """A robot of the world and where it starts, or, if it is fixed, stays."""

    name: str
    declaration: RobotDeclaration
    pose: Pose2
    height: float = 0.0  # of the base above the floor [m]

    @property
    def state(self) -> BodyState:
        """That of its base at the start."""
        lift = self.height if self.declaration.fixed else self.height + DROP
        return BodyState((self.pose.x, self.pose.y, lift), quaternion(0.0, 0.0, self.pose.yaw))


@dataclass(frozen=True)
class Scene:
    """What an engine builds: a floor at z = 0, walls and robots."""

    walls: tuple[Wall, ...]
    robots: tuple[PlacedRobot, ...]
    extent: tuple[float, float, float, float]  # of the floor: lower x, lower y, upper x, upper y [m]


@dataclass(frozen=True)
class JointStates:
    """Of the joints of an arm, and of the two fingers of its gripper after them, each of shape (n + 2,)."""

    positions: Array  # [rad], [m]
    velocities: Array  # [rad/s], [m/s]
    efforts: Array  # of the motors [N m], [N]


@dataclass(frozen=True)
class Carried:
    """A body that is taken to be somewhere else than it is, because an arm would carry it there."""

    name: str
    state: BodyState


@dataclass(frozen=True)
class Overlap:
    """A link of an arm, or the body that it carries, inside something else by a depth [m]."""

    link: str
    other: str  # an entity, also the floor, or a link of the same arm
    depth: float


@dataclass(frozen=True)
class TouchPoint:
    """A point in which an entity touches another, in the map.

    Attributes:
        entity: The other entity.
        position: Of the point [m].
        normal: Unit vector from the entity that was asked for to the other.
        link: The link of an arm that touches; empty for everything else.
    """

    entity: str
    position: Vector
    normal: Vector
    link: str = ""


class UnstablePhysics(Exception):
    """The equations of motion had no usable solution; the simulation has to be reset."""


class UnsavableState(Exception):
    """A state that cannot be saved, or one that was saved and cannot be restored here; the message says why."""


class Engine(Protocol):
    """A physics engine with one scene in it. All calls come from one thread."""

    name: str
    version: str
    steps_per_second: int

    def build(self, scene: Scene) -> None:
        """Replace everything by a scene in its initial state."""

    def reset(self) -> None:
        """Put every body back to where it was built or added, at rest."""

    def step(self, count: int = 1) -> int:
        """Make up to `count` physics steps, to the end of the first after which other pairs of entities touch.

        How many are asked for at once changes nothing: states are the same, bit for bit.

        Returns:
            How many were made, at least one.

        Raises:
            UnstablePhysics: The engine could not, and the world is lost.
        """

    def touching(self) -> frozenset[tuple[str, str]]:
        """The pairs of entities, names in order, in contact in the last step; the floor is left out.

        In the steps of one call of `step` before its last they are those of before the call.
        """

    def touch_points(self, name: str) -> tuple[TouchPoint, ...]:
        """The points in which a robot or an added body touched others in the last step, without the floor.

        Of added bodies they need not be known in a state that was brought back, before the next step.
        """

    def overlaps(self, name: str) -> tuple[str, ...]:
        """The entities other than the floor that an entity interpenetrates now, sorted."""

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        """Add a body that moves as its state says; everything else stays bit for bit as it is."""

    def remove_body(self, name: str) -> None:
        """Remove an added body."""

    def body_state(self, name: str) -> BodyState:
        """The state of a robot's base or of an added body."""

    def set_body_state(self, name: str, state: BodyState) -> None:
        """Put a robot that is not fixed, or an added body, somewhere; a robot's wheels come to rest."""

    def wheel_angles(self, robot: str) -> tuple[float, float]:
        """Angles that the left and right wheel of a robot have turned [rad]."""

    def command_wheels(self, robot: str, left: float, right: float) -> None:
        """Set the speeds that the wheels of a robot are to turn at [rad/s]."""

    def power_wheels(self, robot: str, on: bool) -> None:
        """Cut off the motors of a robot's wheels, which roll freely then, or let them obey their last command.

        After `build` and `reset` they have power.
        """

    def cast_rays(self, robot: str, directions: Array, limit: float) -> Array:
        """Distances along rays from a robot's lidar to what they hit first, the robot itself left out.

        Args:
            robot: Name of the robot.
            directions: Unit vectors in the lidar's frame, shape (n, 3).
            limit: Distance beyond which nothing is seen [m].

        Returns:
            Distances [m], shape (n,), infinite where nothing is hit.
        """

    def joint_states(self, robot: str) -> JointStates:
        """The joints of a robot's arm and gripper."""

    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        """Have the motors of an arm pull its joints to positions that move at velocities, until the next command.

        After `build` and `reset` they pull to the home positions.

        Args:
            robot: Name of the robot.
            positions: Of the arm's joints, shape (n,) [rad].
            velocities: Of the same [rad/s].
        """

    def command_fingers(self, robot: str, position: float, force: float) -> None:
        """Have both fingers of a gripper pull to a position [m] with a force [N] at most, until the next command.

        After `build` and `reset` the gripper is open.
        """

    def link_contacts(self, robot: str) -> frozenset[tuple[str, str]]:
        """What the links of an arm touched in the last step: pairs of link and entity, also the floor."""

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: Carried | None
    ) -> tuple[Overlap, ...]:
        """What the links of an arm would be inside of if its joints were at positions; nothing changes.

        A base that is fixed is left out, and stands in whatever it stands in.

        Args:
            robot: Name of the robot.
            positions: Of the arm's joints, shape (n,) [rad]; the fingers are taken as they are.
            own: Pairs of links of the robot that are looked at; others may be inside each other.
            carried: A body that is taken to be elsewhere; what it would be inside of is told, too.
        """

    def link_pose(self, robot: str, link: str) -> tuple[Vector, Quaternion]:
        """Where a link of a robot is now: position [m] and orientation of its frame."""

    def render(self, view: View) -> Picture:
        """What is seen from a view now; the state stays bit for bit as it is.

        Raises:
            NoRendering: This engine draws nothing here.
        """


@runtime_checkable
class ManyBodies(Protocol):
    """What an engine may offer beyond `Engine`, if bodies by the hundred cost it less than the sum of each."""

    def add_bodies(self, bodies: Sequence[tuple[str, BodyModel, BodyState]]) -> None:
        """Add bodies, as `Engine.add_body` adds each."""

    def remove_bodies(self, names: Sequence[str]) -> None:
        """Remove added bodies."""


@runtime_checkable
class SavesState(Protocol):
    """What an engine may offer beyond `Engine`: its state can be saved, and brought back."""

    def save(self) -> Mapping[str, Any]:
        """All that the future follows from but the scene: values that `sim_nodes.codec` takes.

        Raises:
            UnsavableState: There is too much of it.
        """

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Go on, bit for bit, as the engine that was saved did, also in another process.

        What has been added and moved since the scene was built is forgotten.

        Args:
            saved: What `save` returned in an engine of the same version with the same scene.

        Raises:
            UnsavableState: It is of another scene or version.
        """


@runtime_checkable
class Rewinds(Protocol):
    """What an engine may offer beyond `Engine`: to go back a little, at a small part of the cost of going ahead.

    Nodes of such engines simulate ahead of what is granted to them, where that is expected.
    """

    def checkpoint(self) -> Any:
        """What the future follows from, but the scene and the bodies in it; later steps leave it as it is.

        Returns:
            None where there is no way back from now on. To go back to others than the last may take long.
        """

    def rewind(self, checkpoint: Any) -> None:
        """Go on, bit for bit, as from a checkpoint, since which no body was added, removed or put elsewhere."""
