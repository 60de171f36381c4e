"""The contract of a physics engine, and the data that it takes and returns.

`simulation.py` uses engines through the `Engine` protocol only; `check` tests whether one conforms. Units are SI.
Poses and velocities are in the world frame `map`, orientations are quaternions (w, x, y, z).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

from seoro.deferred import dataclass
from sim_nodes.bodies import (
    IDENTITY,
    BodyModel,
    BodyState,
    Box,
    Capsule,
    Cylinder,
    Hull,
    Mjcf,
    Part,
    Shape,
    Sphere,
    Urdf,
    Wall,
)
from sim_nodes.engine_options import DrivesBodies, ManyBodies, MeasuresWork, Rewinds, SavesState
from sim_nodes.geometry import (
    Array,
    Pose2,
    Quaternion,
    Vector,
    multiply,
    quaternion,
    rotated,
)
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.terrain.ground import FLAT, Ground
from sim_nodes.views import DAYLIGHT, DepthImage, Light, Picture, View

__all__ = [
    "FLOOR",
    "IDENTITY",
    "MAX_OVERLAP",
    "START_CLEARANCE",
    "BodyModel",
    "BodyState",
    "Box",
    "Capsule",
    "CarriedBody",
    "ContactPoint",
    "Cylinder",
    "DrivesBodies",
    "Engine",
    "Hull",
    "JointStates",
    "ManyBodies",
    "MeasuresWork",
    "Mjcf",
    "Overlap",
    "Part",
    "PlacedRobot",
    "Rewinds",
    "SavesState",
    "Scene",
    "Shape",
    "Sphere",
    "UnsavableState",
    "UnstablePhysics",
    "Urdf",
    "Wall",
    "entity_pairs",
]

FLOOR = "floor"
START_CLEARANCE = 0.001  # [m] above the floor at which robots start, so that they start outside of it
MAX_OVERLAP = 1e-3  # [m] of penetration that is not an overlap: contacts at rest have some


@dataclass(frozen=True)
class PlacedRobot:
    """A robot and its initial pose, which a fixed robot keeps."""

    name: str
    declaration: RobotDeclaration
    pose: Pose2
    height: float = 0.0  # of the base above the floor, or of the ground under a robot that stands on terrain [m]
    tilt: Quaternion = IDENTITY  # of the ground under it

    @property
    def state(self) -> BodyState:
        """Initial state of the base."""
        above = self.declaration.standing_height + (0.0 if self.declaration.fixed else START_CLEARANCE)
        turn = quaternion(0.0, 0.0, self.pose.yaw)
        if self.tilt != IDENTITY:
            above, turn = above / rotated(self.tilt, (0.0, 0.0, 1.0))[2], multiply(self.tilt, turn)
        return BodyState((self.pose.x, self.pose.y, self.height + above), turn)


@dataclass(frozen=True)
class Scene:
    """The static scene of an engine: a floor at z = 0 with terrain, walls and robots, and its light."""

    walls: tuple[Wall, ...]
    robots: tuple[PlacedRobot, ...]
    extent: tuple[float, float, float, float]  # of the floor: lower x, lower y, upper x, upper y [m]
    ground: Ground = FLAT
    light: Light = DAYLIGHT


@dataclass(frozen=True)
class JointStates:
    """States of position-controlled joints, followed by the fingers of a gripper, if any; arrays of shape (n,)."""

    positions: Array  # [rad], [m]
    velocities: Array  # [rad/s], [m/s]
    efforts: Array  # of the motors [N m], [N]


@dataclass(frozen=True)
class CarriedBody:
    """A body at a hypothetical pose: where the arm would carry it."""

    name: str
    state: BodyState


@dataclass(frozen=True)
class Overlap:
    """A penetration by `depth` [m] of a link of an arm, or of the body that it carries, into `other`."""

    link: str
    other: str  # an entity, the floor, or a link of the same arm
    depth: float


@dataclass(frozen=True)
class ContactPoint:
    """A point of contact between two entities, in `map`.

    Attributes:
        entity: The other entity.
        position: Point [m].
        normal: Unit vector from the queried entity towards the other one.
        link: Link of an arm that touches; empty otherwise.
    """

    entity: str
    position: Vector
    normal: Vector
    link: str = ""


def entity_pairs(
    contacts: Iterable[Iterable[int]], owners: Mapping[int, str] | Sequence[str]
) -> frozenset[tuple[str, str]]:
    """Return the pairs of different entities in contact, each sorted by name, without the floor.

    Args:
        contacts: Pairs of numbers of shapes or bodies.
        owners: Entity of each number.
    """
    pairs = set()
    for first, second in contacts:
        a, b = owners[first], owners[second]
        if a != b and FLOOR not in (a, b):
            pairs.add((min(a, b), max(a, b)))
    return frozenset(pairs)


class UnstablePhysics(Exception):
    """The physics has diverged; the simulation must be reset."""


class UnsavableState(Exception):
    """A state cannot be saved, or a saved state cannot be restored here; the message gives the reason."""


class Engine(Protocol):
    """A physics engine with one scene. All calls come from one thread.

    Attributes:
        name: Name of the engine.
        version: Version of the engine.
        steps_per_second: Physics steps per simulated second; a tick of 20 ms is a whole number of steps.
    """

    name: str
    version: str
    steps_per_second: int

    def build(self, scene: Scene) -> None:
        """Replace the scene; afterwards, everything is in its initial state."""

    def reset(self) -> None:
        """Return every body to the state in which it was built or added; robots are at rest, without commands."""

    def step(self, count: int = 1) -> int:
        """Make up to `count` physics steps; stop after a step in which the pairs in contact change.

        Batches do not affect results: the states are bit-identical to those of single steps.

        Returns:
            Number of steps made, at least one.

        Raises:
            UnstablePhysics: The physics has diverged.
        """

    def touching(self) -> frozenset[tuple[str, str]]:
        """Return the pairs of entities in contact in the last step, each pair sorted by name; without the floor.

        In the earlier steps of one call of `step`, the pairs are those before the call.
        """

    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        """Return the contact points of a robot or an added body in the last step; without the floor.

        After a state is restored, those of added bodies may be missing until the next step.
        """

    def overlaps(self, name: str) -> tuple[str, ...]:
        """Return the entities that an entity now penetrates, sorted; without the floor."""

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        """Add a body in a state, also a moving one; all other states stay bit-identical."""

    def remove_body(self, name: str) -> None:
        """Remove an added body."""

    def body_state(self, name: str) -> BodyState:
        """Return the state of a robot's base or of an added body."""

    def set_body_state(self, name: str, state: BodyState) -> None:
        """Set the state of an added body or of a robot that is not fixed; the robot's wheels come to rest."""

    def wheel_angles(self, robot: str) -> tuple[float, ...]:
        """Return the angles that the motors of a drive have turned since the start [rad].

        Motors are in the order of `robots/kinematics.py`: the left and right wheel of a differential drive; the
        wheels of a planar one, followed by its steering joints.
        """

    def command_wheels(self, robot: str, *targets: float) -> None:
        """Set the targets of the motors of a drive, which hold until the next command.

        Args:
            robot: Name of the robot.
            targets: Speeds of wheels [rad/s] and angles of steering joints [rad], in the order of `wheel_angles`.
                A planar drive is pulled to the velocity by these values (`robots/traction.py`).
        """

    def power_wheels(self, robot: str, on: bool) -> None:
        """Switch the power of the wheel motors. Without it, wheels roll freely; with it, the last command holds.

        `build` and `reset` switch it on.
        """

    def cast_rays(
        self, robot: str, link: str, directions: Array, limit: float, position: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        """Return the distances along rays from a point of a robot to the first hit, ignoring the robot itself.

        Args:
            robot: Name of the robot.
            link: Link of the robot.
            directions: Unit vectors in the frame of the link, shape (n, 3).
            limit: Maximum range [m].
            position: Origin of the rays in the frame of the link [m].

        Returns:
            Distances [m], shape (n,); infinite without a hit.
        """

    def joint_states(self, robot: str) -> JointStates:
        """Return the states of a robot's position-controlled joints and fingers."""

    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        """Set the targets of an arm's motors: positions that move at the velocities until the next command.

        `build` and `reset` set the home positions.

        Args:
            robot: Name of the robot.
            positions: Target positions, shape (n,) [rad], [m].
            velocities: Velocities of the targets, shape (n,) [rad/s], [m/s].
        """

    def command_fingers(self, robot: str, position: float, force: float) -> None:
        """Set the target position [m] of both fingers and the maximum force of each [N], until the next command.

        `build` and `reset` open the gripper.
        """

    def link_contacts(self, robot: str) -> frozenset[tuple[str, str]]:
        """Return the pairs of link and entity (or `floor`) that touched in the last step."""

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: CarriedBody | None
    ) -> tuple[Overlap, ...]:
        """Return the overlaps that the links of an arm would have at joint positions; the state stays unchanged.

        The base of a fixed robot is ignored.

        Args:
            robot: Name of the robot.
            positions: Positions of the arm's joints, shape (n,) [rad], [m]; the fingers stay where they are.
            own: Pairs of links of the robot to check; others may overlap.
            carried: A body that is checked at another pose than its own.
        """

    def link_pose(self, robot: str, link: str) -> tuple[Vector, Quaternion]:
        """Return the pose of a link's frame in `map`: position [m] and orientation."""

    def joint_load(self, robot: str, link: str) -> tuple[Vector, Vector]:
        """Return the load that a link, and all that hangs on it, exerted on the link before it in the last step.

        Args:
            robot: Name of the robot.
            link: Child of a fixed joint, with a `force_torque` sensor in the robot's declaration.

        Returns:
            Force [N], and torque about the origin of the link [N m], both in the frame of the link.
        """

    def render_depth(self, view: View) -> DepthImage:
        """Measure the distances of drawn surfaces in a view of the present state, which stays bit-identical.

        Raises:
            NoRendering: The engine cannot render here.
        """

    def render(self, view: View) -> Picture:
        """Render a view of the present state; the state stays bit-identical.

        Raises:
            NoRendering: The engine cannot render here.
        """
