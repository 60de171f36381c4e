"""Declarations of robots beyond their URDF: sensors, motors and limits."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Annotated, Self

import numpy as np
from pydantic import BeforeValidator, Field, NonNegativeFloat, PositiveFloat, PositiveInt, model_validator

from sim_nodes.files import Declared
from sim_nodes.geometry import Array
from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.footprint import Corners, Footprint, read_footprint
from sim_nodes.robots.navigation import NavigationDeclaration
from sim_nodes.robots.postures import Postures
from sim_nodes.robots.sensor_declarations import MAX_SENSORS, LinkPart, Mount, SensorDeclaration, WithLens

OTHER_DEVICES = frozenset({"bumper", "gripper", "imu", "joints", "lidar", "motors", "odometry", "robot"})
"""Names of devices of robots besides cameras and the sensors of the list."""


class OdometryDeclaration(Declared):
    """Errors of wheel odometry: standard deviations that grow with the square root of the distance."""

    distance_noise: float  # of distance, per metre driven [m / sqrt(m)]
    turn_noise: float  # of heading, per radian turned [rad / sqrt(rad)]
    drift_noise: float  # of heading, per metre driven [rad / sqrt(m)]


class LidarDeclaration(Declared):
    """A planar lidar."""

    link: str
    x: float  # mount in the base's frame [m]
    y: float
    yaw: float  # [rad]
    beams: PositiveInt  # per turn
    rate: PositiveFloat  # turns per second [Hz]
    min_range: PositiveFloat  # [m]
    max_range: PositiveFloat
    noise: NonNegativeFloat  # standard deviation of a range [m]
    resolution: NonNegativeFloat = 0.0  # step of the ranges [m]; 0 for none
    dropout: float = Field(0.0, ge=0.0, le=1.0)  # probability that a beam has no return


class CameraDeclaration(WithLens, Mount, LinkPart):
    """A camera that is fixed to a link."""

    x: float
    y: float
    z: float


class LocalisationDeclaration(Declared):
    """Parameters of the particle filter: those of Nav2's AMCL by the same names, and further ones.

    With `recovery_alpha_slow` and `recovery_alpha_fast` above zero (such as 0.001 and 0.1), random particles are
    added while scans fit worse than before. A robot that was carried elsewhere may then find itself, but faults of
    its lidar may make it get lost.
    """

    min_particles: PositiveInt = 400
    max_particles: PositiveInt = 2000
    pf_err: PositiveFloat = 0.05  # maximum error by the number of particles: Kullback-Leibler distance
    pf_z: PositiveFloat = 0.99  # quantile of the normal distribution for the probability of that bound
    max_beams: PositiveInt = 60
    alpha1: NonNegativeFloat = 0.1  # error of rotation from rotation
    alpha2: NonNegativeFloat = 0.1  # error of rotation from translation
    alpha3: NonNegativeFloat = 0.1  # error of translation from translation
    alpha4: NonNegativeFloat = 0.1  # error of translation from rotation
    alpha5: NonNegativeFloat = 0.1  # error to the side from translation, of omnidirectional drives
    sigma_hit: PositiveFloat = 0.1  # [m]
    z_hit: PositiveFloat = 0.5
    z_rand: PositiveFloat = 0.5
    laser_likelihood_max_dist: PositiveFloat = 1.0  # [m]
    update_min_d: NonNegativeFloat = 0.1  # [m]
    update_min_a: NonNegativeFloat = 0.1  # [rad]
    recovery_alpha_slow: NonNegativeFloat = 0.0  # rate of the slow average of the fit; the fast one follows
    recovery_alpha_fast: NonNegativeFloat = 0.0
    beam_weight: PositiveFloat = 0.1  # weight of a beam relative to an independent measurement
    # [m, m, rad]
    initial_deviation: tuple[NonNegativeFloat, NonNegativeFloat, NonNegativeFloat] = (0.1, 0.1, 0.05)
    global_particles: PositiveInt = 20_000  # maximum during a global search
    global_beam_weight: PositiveFloat = 0.03


class ImuDeclaration(Declared):
    """An inertial measurement unit at the origin of the base; biases are drawn once, noise for each sample."""

    rate: PositiveFloat  # [Hz]
    accelerometer_noise: NonNegativeFloat  # standard deviations [m/s^2]
    accelerometer_bias: NonNegativeFloat
    gyroscope_noise: NonNegativeFloat  # [rad/s]
    gyroscope_bias: NonNegativeFloat


class ZoneDeclaration(Declared):
    """A zone of a bumper, from one bearing to another, counterclockwise [rad]."""

    name: str
    start: float
    end: float


class BumperDeclaration(Declared):
    """A bumper around the base; where zones meet, the first one is pressed."""

    lowest: float  # [m] above the floor
    highest: float
    zones: tuple[ZoneDeclaration, ...]


class BatteryDeclaration(Declared):
    """A battery; see `drive.py`."""

    capacity: PositiveFloat  # [Wh]
    idle: NonNegativeFloat  # power at rest [W]
    driving: NonNegativeFloat  # power while the wheels are commanded to turn [W]
    charge: float = Field(1.0, ge=0.0, le=1.0)  # at the start


class MobileDeclaration(Declared):
    """A base that drives, localises itself and has sensors.

    Without a lidar, it is localised by its odometry from the initial pose on.
    """

    radius: PositiveFloat  # of the smallest circle around the base's origin that contains the robot [m]
    # corners of its outline on the floor, counterclockwise [m]; without, it is the circle of `radius`
    footprint: Annotated[Footprint, BeforeValidator(read_footprint, json_schema_input_type=Corners)] | None = None
    clearance: PositiveFloat  # from the base's origin to walls, minimum of plans [m]
    drive: DriveDeclaration
    odometry: OdometryDeclaration
    lidar: LidarDeclaration | None = None
    imu: ImuDeclaration | None = None
    bumper: BumperDeclaration | None = None
    battery: BatteryDeclaration | None = None
    localisation: LocalisationDeclaration = LocalisationDeclaration()
    navigation: NavigationDeclaration = NavigationDeclaration()


class JointDeclaration(Declared):
    """A position-controlled joint, which turns or slides; its limits are in the URDF.

    Units are those of a joint that turns, and of one that slides.
    """

    name: str
    home: float  # initial position [rad], [m]
    max_acceleration: PositiveFloat  # [rad/s^2], [m/s^2]
    stiffness: PositiveFloat  # motor torque or force per position error [N m/rad], [N/m]
    damping: PositiveFloat  # motor torque or force per velocity error [N m s/rad], [N s/m]
    armature: PositiveFloat  # inertia of rotor and gear at the joint [kg m^2], [kg]


class FingerMotion(Declared):
    """Openings of a gripper whose fingers turn, at positions of their joints.

    Beyond the table, the opening goes on as between its last two rows.
    """

    positions: tuple[float, ...] = Field(min_length=2)  # [rad], increasing
    openings: tuple[float, ...] = Field(min_length=2)  # [m], increasing or decreasing

    @model_validator(mode="after")
    def _monotonic(self) -> Self:
        steps, ways = np.diff(self.positions), np.diff(self.openings)
        if (
            len(self.positions) != len(self.openings)
            or (steps <= 0.0).any()
            or np.ptp(np.sign(ways))
            or not ways.all()
        ):
            raise ValueError(
                "expected as many `positions`, which increase, as `openings`, which increase or decrease"
            )
        return self

    def position_of(self, opening: float) -> float:
        """Return the position of the joints at an opening [m]."""
        order = 1 if self.openings[-1] > self.openings[0] else -1
        return _interpolated(opening, self.openings[::order], self.positions[::order])

    def opening_of(self, position: float) -> float:
        """Return the opening [m] at a position of the joints [rad]."""
        return _interpolated(position, self.positions, self.openings)

    @property
    def lever(self) -> float:
        """Mean motion of a finger by the angle of its joint [m/rad], and torque by its force [N m/N]."""
        way = abs(self.openings[-1] - self.openings[0]) / 2.0
        return way / (self.positions[-1] - self.positions[0])


def _interpolated(at: float, places: Sequence[float], values: Sequence[float]) -> float:
    """Interpolate a table with increasing places, and extrapolate it."""
    index = min(max(bisect_right(places, at), 1), len(places) - 1)
    share = (at - places[index - 1]) / (places[index] - places[index - 1])
    return values[index - 1] + share * (values[index] - values[index - 1])


class GripperDeclaration(Declared):
    """A gripper of two fingers.

    Fingers that slide are each half the opening away from the point where both meet. For fingers that turn,
    `turning` has the opening, and stiffness, damping and armature are those of their joints.
    """

    joints: tuple[str, str]
    links: tuple[str, str]  # the fingers
    stroke: PositiveFloat  # maximum opening [m]
    max_speed: PositiveFloat  # of the opening [m/s]
    min_force: PositiveFloat  # of a finger [N]
    max_force: PositiveFloat
    usual_force: PositiveFloat
    stiffness: PositiveFloat  # motor force per position error [N/m]
    damping: PositiveFloat  # motor force per velocity [N s/m]
    armature: PositiveFloat  # inertia of motor and gear at the finger [kg]
    friction: PositiveFloat
    torsional_friction: PositiveFloat  # [m]
    turning: FingerMotion | None = None

    def position_of(self, opening: float) -> float:
        """Return the position of the joints at an opening [m]: [m], or [rad] of fingers that turn."""
        return opening / 2.0 if self.turning is None else self.turning.position_of(opening)

    def opening_of(self, positions: Array) -> float:
        """Return the opening [m] at positions of both joints."""
        if self.turning is None:
            return float(positions.sum())
        return sum(self.turning.opening_of(each) for each in positions.tolist()) / 2.0

    def opening_speed(self, speeds: Array) -> float:
        """Return the speed of the opening [m/s] at speeds of both joints; a mean one for fingers that turn."""
        if self.turning is None:
            return float(speeds.sum())
        opens = 1.0 if self.turning.openings[-1] > self.turning.openings[0] else -1.0
        return opens * self.turning.lever * float(speeds.sum())

    def effort_of(self, force: float) -> float:
        """Return the effort of a joint [N], [N m] at a force of its finger [N]."""
        return force if self.turning is None else force * self.turning.lever


class ArmDeclaration(Declared):
    """Position-controlled joints: an arm, or a body that moves by its joints, such as one with legs.

    Attributes:
        tool_link: Last link of an arm, whose `joints` are all movable joints from the base to it, in order.
            Without it, joints may be anywhere, and paths are not checked for collisions.
        gripper: Gripper of an arm.
    """

    tool_link: str | None = None
    joints: tuple[JointDeclaration, ...] = Field(min_length=1)
    gripper: GripperDeclaration | None = None

    @property
    def home(self) -> dict[str, float]:
        """Initial positions by joint [rad], [m], without the fingers."""
        return {joint.name: joint.home for joint in self.joints}

    @property
    def fingers(self) -> tuple[str, ...]:
        """Joints of the fingers; empty without a gripper."""
        return () if self.gripper is None else self.gripper.joints

    @property
    def finger_links(self) -> tuple[str, ...]:
        """Links of the fingers; empty without a gripper."""
        return () if self.gripper is None else self.gripper.links

    @model_validator(mode="after")
    def _gripper_has_tool(self) -> Self:
        if self.gripper is not None and self.tool_link is None:
            raise ValueError("missing `tool_link`; expected the last link of the arm that has the `gripper`")
        return self


class NativeModel(Declared):
    """A model in MJCF, which MuJoCo loads instead of the URDF: its text, and its assets by file name."""

    text: str
    assets: tuple[tuple[str, bytes], ...] = ()


class RobotDeclaration(Declared):
    """A kind of robot.

    Args:
        source: Text of its URDF, as clients get it.
        urdf: Canonical form of its URDF, for engines.
        meshes: Files that the canonical form names, by file name; see `Urdf`.
        native: Its file in MJCF; None if it has another format.
        notes: Parts of its file without effect.
        kinds: Actor types that it can represent, most specific first.
        fixed: Whether it is fixed to the world.
        standing_height: Initial height of its base above the floor or its stand [m].
        low_friction_links: Links that slide, such as casters.
        postures: Positions of its joints by name of the posture; other joints keep their last goal.
    """

    model: str
    source: str
    urdf: str
    meshes: tuple[tuple[str, bytes], ...] = ()
    native: NativeModel | None = None
    notes: tuple[str, ...] = ()
    kinds: tuple[str, ...]
    base_link: str
    fixed: bool = False
    standing_height: NonNegativeFloat = 0.0
    body_friction: PositiveFloat
    low_friction_links: tuple[str, ...] = ()
    mobile: MobileDeclaration | None = None
    arm: ArmDeclaration | None = None
    postures: Postures = ()
    cameras: tuple[CameraDeclaration, ...] = ()
    sensors: tuple[SensorDeclaration, ...] = Field((), max_length=MAX_SENSORS)

    @model_validator(mode="after")
    def _names_of_devices(self) -> Self:
        cameras, sensors = ([each.name for each in some] for some in (self.cameras, self.sensors))
        for what, names in (("camera", cameras), ("sensor", sensors)):
            for name in names:
                if name in OTHER_DEVICES or (cameras + sensors).count(name) > 1:
                    raise ValueError(f"duplicate name {name!r} of a {what}; names of a robot's devices are unique")
        return self
