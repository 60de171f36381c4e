"""What an engine must offer, and the data that it is given and gives back.

The core in `simulation.py` knows an engine by the `Engine` protocol only; `check` measures whether one keeps it.
Poses and velocities are in the world's frame `map`, SI units, orientations as quaternions (w, x, y, z).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from sim_nodes.geometry import Array, Pose2, Quaternion, Vector, yaw_of
from sim_nodes.robots.declaration import RobotDeclaration

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
    """A shape at a place in its body."""

    shape: Shape
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = IDENTITY


@dataclass(frozen=True)
class BodyModel:
    """A rigid body: its parts, its mass [kg] and the sliding friction of its surface.

    What friction two surfaces have with one another is the engine's.
    """

    parts: tuple[Part, ...]
    mass: float = 1.0
    friction: float = 1.0
    static: bool = False  # immovable by forces; it may still be put elsewhere


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


@dataclass(frozen=True)
class PlacedRobot:
    """A robot of the world and where it starts."""

    name: str
    declaration: RobotDeclaration
    pose: Pose2


@dataclass(frozen=True)
class Scene:
    """What an engine builds: a floor at z = 0, walls and robots."""

    walls: tuple[Wall, ...]
    robots: tuple[PlacedRobot, ...]
    extent: tuple[float, float, float, float]  # of the floor: lower x, lower y, upper x, upper y [m]


class UnstablePhysics(Exception):
    """The equations of motion had no usable solution; the simulation has to be reset."""


class Engine(Protocol):
    """A physics engine with one scene in it. All calls come from one thread."""

    name: str
    version: str
    steps_per_second: int

    def build(self, scene: Scene) -> None:
        """Replace everything by a scene in its initial state."""

    def reset(self) -> None:
        """Put every body back to where it was built or added, at rest."""

    def step(self) -> None:
        """Make one physics step.

        Raises:
            UnstablePhysics: The engine could not, and the world is lost.
        """

    def touching(self) -> frozenset[tuple[str, str]]:
        """The pairs of entities, names in order, in contact in the last step; the floor is left out."""

    def overlaps(self, name: str) -> tuple[str, ...]:
        """The entities other than the floor that an entity interpenetrates now, sorted."""

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        """Add a body; everything else stays bit for bit as it is."""

    def remove_body(self, name: str) -> None:
        """Remove an added body."""

    def body_state(self, name: str) -> BodyState:
        """The state of a robot's base or of an added body."""

    def set_body_state(self, name: str, state: BodyState) -> None:
        """Put a robot or an added body somewhere; a robot's wheels come to rest."""

    def wheel_angles(self, robot: str) -> tuple[float, float]:
        """Angles that the left and right wheel of a robot have turned [rad]."""

    def command_wheels(self, robot: str, left: float, right: float) -> None:
        """Set the speeds that the wheels of a robot are to turn at [rad/s]."""

    def cast_rays(self, robot: str, directions: Array, limit: float) -> Array:
        """Distances along rays from a robot's lidar to what they hit first, the robot itself left out.

        Args:
            robot: Name of the robot.
            directions: Unit vectors in the lidar's frame, shape (n, 3).
            limit: Distance beyond which nothing is seen [m].

        Returns:
            Distances [m], shape (n,), infinite where nothing is hit.
        """
