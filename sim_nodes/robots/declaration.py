"""What is declared of a robot besides its URDF: what it senses, how its motors move it."""

from __future__ import annotations

from functools import cache
from importlib import resources
from pathlib import Path
from typing import Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    NonNegativeFloat,
    PositiveFloat,
    PositiveInt,
    ValidationError,
    model_validator,
)

from sim_nodes.files import NAME, FileError, Lines, problems, read_text, read_yaml
from sim_nodes.geometry import Quaternion, Vector, quaternion
from sim_nodes.views import MAX_FOV, MAX_SIZE, MIN_FOV, MIN_SIZE, Lens

OTHER_DEVICES = frozenset({"bumper", "gripper", "imu", "joints", "lidar", "motors", "odometry", "robot"})
"""Names of what a robot may have besides cameras."""


class _Declared(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class DriveDeclaration(_Declared):
    """A differential drive: two wheels on one axle, at the origin of the base."""

    left_joint: str
    right_joint: str
    wheel_radius: PositiveFloat  # [m]
    wheel_separation: PositiveFloat  # [m]
    max_speed: PositiveFloat  # [m/s]
    max_acceleration: PositiveFloat  # [m/s^2]
    max_turn_rate: PositiveFloat  # [rad/s]
    max_turn_acceleration: PositiveFloat  # [rad/s^2]
    motor_gain: PositiveFloat  # torque per error of speed [N m s/rad]
    motor_torque: PositiveFloat  # limit [N m]
    armature: PositiveFloat  # inertia of rotor and gear at the wheel [kg m^2]
    wheel_friction: PositiveFloat


class OdometryDeclaration(_Declared):
    """Errors of wheel odometry: standard deviations that grow with the square root of what was driven."""

    distance_noise: float  # of distance, per metre driven [m / sqrt(m)]
    turn_noise: float  # of heading, per radian turned [rad / sqrt(rad)]
    drift_noise: float  # of heading, per metre driven [rad / sqrt(m)]


class LidarDeclaration(_Declared):
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
    resolution: NonNegativeFloat = 0.0  # that ranges are multiples of [m]
    dropout: float = Field(0.0, ge=0.0, le=1.0)  # probability that a beam sees nothing


class CameraDeclaration(_Declared):
    """A camera that is fixed to a link, looking along its own x axis with z up."""

    name: str = Field(pattern=NAME)
    link: str
    x: float  # mount in the link's frame [m]
    y: float
    z: float
    roll: float = 0.0  # [rad]
    pitch: float = 0.0
    yaw: float = 0.0
    fov: float = Field(ge=MIN_FOV, le=MAX_FOV)  # vertical [rad]
    width: int = Field(ge=MIN_SIZE, le=MAX_SIZE)  # [pixels]
    height: int = Field(ge=MIN_SIZE, le=MAX_SIZE)

    @property
    def lens(self) -> Lens:
        """How it looks."""
        return Lens(self.fov, self.width, self.height)

    @property
    def position(self) -> Vector:
        """Where it is in the link's frame [m]."""
        return self.x, self.y, self.z

    @property
    def orientation(self) -> Quaternion:
        """How it is turned in the link's frame."""
        return quaternion(self.roll, self.pitch, self.yaw)


class LocalisationDeclaration(_Declared):
    """The particle filter: parameters of Nav2's AMCL under their names there, and what that does not have.

    With `recovery_alpha_slow` and `recovery_alpha_fast` above zero (such as 0.001 and 0.1) there are
    random particles when scans fit worse than they did: the robot may find itself after it has been carried
    elsewhere, and may lose itself by faults of its lidar.
    """

    min_particles: PositiveInt = 400
    max_particles: PositiveInt = 2000
    pf_err: PositiveFloat = 0.05  # largest error by the number of particles, as Kullback-Leibler distance
    pf_z: PositiveFloat = 0.99  # quantile of the normal distribution for keeping it
    max_beams: PositiveInt = 60
    alpha1: NonNegativeFloat = 0.1  # error of rotation from rotation
    alpha2: NonNegativeFloat = 0.1  # error of rotation from translation
    alpha3: NonNegativeFloat = 0.1  # error of translation from translation
    alpha4: NonNegativeFloat = 0.1  # error of translation from rotation
    sigma_hit: PositiveFloat = 0.1  # [m]
    z_hit: PositiveFloat = 0.5
    z_rand: PositiveFloat = 0.5
    laser_likelihood_max_dist: PositiveFloat = 1.0  # [m]
    update_min_d: NonNegativeFloat = 0.1  # [m]
    update_min_a: NonNegativeFloat = 0.1  # [rad]
    recovery_alpha_slow: NonNegativeFloat = 0.0  # how fast the slow and the fast average of the fit follow
    recovery_alpha_fast: NonNegativeFloat = 0.0
    beam_weight: PositiveFloat = 0.1  # what a beam counts, compared with an independent measurement
    initial_deviation: tuple[NonNegativeFloat, NonNegativeFloat, NonNegativeFloat] = (
        0.1,
        0.1,
        0.05,
    )  # [m, m, rad]
    global_particles: PositiveInt = 20_000  # over the whole map, at most, while the robot looks for itself
    global_beam_weight: PositiveFloat = 0.03


class ImuDeclaration(_Declared):
    """An inertial measurement unit at the origin of the base; biases are drawn once, noise for each sample."""

    rate: PositiveFloat  # [Hz]
    accelerometer_noise: NonNegativeFloat  # standard deviations [m/s^2]
    accelerometer_bias: NonNegativeFloat
    gyroscope_noise: NonNegativeFloat  # [rad/s]
    gyroscope_bias: NonNegativeFloat


class ZoneDeclaration(_Declared):
    """A zone of a bumper, from one bearing to another, to the left [rad]."""

    name: str
    start: float
    end: float


class BumperDeclaration(_Declared):
    """A bumper about the base; where zones meet, the first of them is pressed."""

    lowest: float  # [m] above the floor
    highest: float
    zones: tuple[ZoneDeclaration, ...]


class BatteryDeclaration(_Declared):
    """A battery; see `battery.py`."""

    capacity: PositiveFloat  # [Wh]
    idle: NonNegativeFloat  # power that it gives while the base stands [W]
    driving: NonNegativeFloat  # and while its wheels are told to turn [W]
    charge: float = Field(1.0, ge=0.0, le=1.0)  # at the start


class MobileDeclaration(_Declared):
    """A base that drives, finds its way and sees what is about it."""

    radius: PositiveFloat  # of the smallest circle about the base's origin that holds the robot [m]
    clearance: PositiveFloat  # from the base's origin to walls that plans keep [m]
    drive: DriveDeclaration
    odometry: OdometryDeclaration
    lidar: LidarDeclaration
    imu: ImuDeclaration | None = None
    bumper: BumperDeclaration | None = None
    battery: BatteryDeclaration | None = None
    localisation: LocalisationDeclaration = LocalisationDeclaration()


class JointDeclaration(_Declared):
    """A joint of an arm; its range, speed and torque are in the URDF."""

    name: str
    home: float  # position at the start [rad]
    max_acceleration: PositiveFloat  # [rad/s^2]
    stiffness: PositiveFloat  # torque of the motor per error of position [N m/rad]
    damping: PositiveFloat  # torque of the motor per error of speed [N m s/rad]
    armature: PositiveFloat  # inertia of rotor and gear at the joint [kg m^2]


class GripperDeclaration(_Declared):
    """A parallel gripper: two fingers on a line, each off from where they meet by half the opening."""

    joints: tuple[str, str]
    links: tuple[str, str]  # the fingers
    stroke: PositiveFloat  # the greatest opening [m]
    max_speed: PositiveFloat  # of the opening [m/s]
    min_force: PositiveFloat  # of a finger [N]
    max_force: PositiveFloat
    usual_force: PositiveFloat
    stiffness: PositiveFloat  # force of the motor per error of position [N/m]
    damping: PositiveFloat  # force of the motor per speed [N s/m]
    armature: PositiveFloat  # inertia of motor and gear at the finger [kg]
    friction: PositiveFloat
    torsional_friction: PositiveFloat  # [m]


class ArmDeclaration(_Declared):
    """An arm with a gripper; `joints` are in order from the base, and all that move between that and the tool."""

    tool_link: str
    joints: tuple[JointDeclaration, ...]
    gripper: GripperDeclaration


class RobotDeclaration(_Declared):
    """A kind of robot, made of the parts that it has.

    `urdf` is the text of its URDF, which the file of the declaration names; `kinds` are the actor types
    it can stand for, most specific first; `low_friction_links` slide, such as casters.
    """

    model: str
    urdf: str
    kinds: tuple[str, ...]
    base_link: str
    fixed: bool = False  # to the world, where it is placed
    body_friction: PositiveFloat
    low_friction_links: tuple[str, ...] = ()
    mobile: MobileDeclaration | None = None
    arm: ArmDeclaration | None = None
    cameras: tuple[CameraDeclaration, ...] = ()

    @model_validator(mode="after")
    def _names_of_cameras(self) -> Self:
        names = [camera.name for camera in self.cameras]
        for name in names:
            if name in OTHER_DEVICES or names.count(name) > 1:
                raise ValueError(
                    f"the name of camera {name!r} is taken: that of each of a robot's devices is its own"
                )
        return self


def available_robots() -> tuple[str, ...]:
    """Names of the kinds of robot that can be put into a world."""
    files = resources.files(__package__).iterdir()
    return tuple(sorted(entry.name.removesuffix(".yaml") for entry in files if entry.name.endswith(".yaml")))


@cache
def load_robot(model: str) -> RobotDeclaration:
    """The declaration of a kind of robot by name, one of `available_robots()`."""
    return read_robot(Path(__file__).parent / f"{model}.yaml")


def read_robot(path: Path) -> RobotDeclaration:
    """The declaration of a robot in a file, with the URDF that it names, from its folder.

    Raises:
        FileError: One of the two cannot be read, or the declaration is wrong.
    """
    text = read_text(path)
    content = read_yaml(text, str(path))
    if not isinstance(content, dict) or not isinstance(content.get("urdf"), str):
        raise FileError(f"{path}: it has to name its `urdf`, a file beside it")
    try:
        return RobotDeclaration.model_validate({**content, "urdf": read_text(path.parent / content["urdf"])})
    except ValidationError as error:
        raise FileError(problems(error, Lines(text, str(path)), RobotDeclaration)) from error
