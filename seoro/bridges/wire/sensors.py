"""Sensors of robots: their latest samples, and watches on what they say. Faults lie on all of it."""

from __future__ import annotations

from seoro.bridges.wire.geometry import Pose, Vector3
from seoro.bridges.wire.message import Empty, Message, Verb


class SensorName(Message):
    """A sensor of a robot."""

    robot: str
    sensor: str


class LaserScan(Message):
    """Ranges [m], infinite where nothing was hit, at bearings to the left from straight ahead [rad]."""

    ranges: tuple[float, ...]
    bearings: tuple[float, ...]


class OdometrySample(Message):
    """Pose of the base in `odom`, length of its path [m], velocity ahead [m/s] and to the left [rad/s]."""

    pose: Pose
    travelled: float
    linear: float
    angular: float


class ImuSample(Message):
    """Acceleration against free fall [m/s^2] and rates of turning [rad/s], in the frame of the base."""

    acceleration: Vector3
    angular_rate: Vector3


class Bump(Message):
    """A zone of a bumper that is pressed by an entity, and since when [s]."""

    zone: str
    entity: str
    since: float


class BumperSample(Message):
    """All that presses a bumper."""

    bumps: tuple[Bump, ...]


class SensorSample(Message):
    """The last sample that has arrived: when it was taken [s], and in one of the parts what it says."""

    time: float
    lidar: LaserScan | None = None
    odometry: OdometrySample | None = None
    imu: ImuSample | None = None
    bumper: BumperSample | None = None


class WatchSensor(Message):
    """Report when the next sample of a sensor arrives."""

    id: str
    robot: str
    sensor: str


class WatchBumper(Message):
    """Report when a zone of a robot's bumper is pressed by an entity; of any zone, by anything, without names."""

    id: str
    robot: str
    zone: str = ""
    entity: str = ""


class WatchRange(Message):
    """Report when a lidar sees something nearer than `distance` [m] from one bearing to another."""

    id: str
    robot: str
    sensor: str
    distance: float
    start: float
    end: float


class CheckRate(Message):
    """Count the samples of a sensor that arrive in `duration` [s]; aborted when their rate is out of bounds.

    Bounds are in samples per second, and included.
    """

    id: str
    robot: str
    sensor: str
    lowest: float
    highest: float
    duration: float


GET_SENSOR_SAMPLE = Verb("get_sensor_sample", SensorName, SensorSample)
WATCH_SENSOR = Verb("watch_sensor", WatchSensor, Empty)
WATCH_BUMPER = Verb("watch_bumper", WatchBumper, Empty)
WATCH_RANGE = Verb("watch_range", WatchRange, Empty)
CHECK_RATE = Verb("check_rate", CheckRate, Empty)
