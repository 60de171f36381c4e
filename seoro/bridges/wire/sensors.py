"""Sensors of robots: their latest samples, and watches on them. Samples contain injected faults."""

from __future__ import annotations

from seoro.bridges.wire.geometry import Vector3
from seoro.bridges.wire.message import Empty, Message, Query, TrackedRequest, Verb
from seoro.robotics.geometry import Pose3D


class SensorName(Message):
    """A sensor of a robot."""

    robot: str
    sensor: str


class LaserScan(Message):
    """Ranges [m], infinite without a hit, at bearings from the x axis to the left [rad]."""

    ranges: tuple[float, ...]
    bearings: tuple[float, ...]


class OdometrySample(Message):
    """Pose of the base in `odom`, length of its path [m], velocity ahead [m/s] and to the left [rad/s], [m/s]."""

    pose: Pose3D
    travelled: float
    linear: float
    angular: float
    lateral: float = 0.0


class ImuSample(Message):
    """Proper acceleration [m/s^2] and angular rates [rad/s], in the frame of the base."""

    acceleration: Vector3
    angular_rate: Vector3


class Bump(Message):
    """Zone of a bumper that an entity presses, since a time [s]."""

    zone: str
    entity: str
    since: float


class BumperSample(Message):
    """Pressed zones of a bumper."""

    bumps: tuple[Bump, ...]


class PointCloud(Message):
    """Points of a 3D lidar in the sensor's frame [m], ring by ring from below.

    `points` are little-endian floats of 32 bits: x, y and z of each point; not a number without a return.
    """

    rings: int
    beams: int  # of a ring
    points: bytes


class RangeSample(Message):
    """Distance that a sonar measures [m]; infinite without an echo."""

    range: float


class DepthSample(Message):
    """Distances along the viewing direction by row from the top, and the picture of an RGB-D camera.

    `depths` are little-endian floats of 32 bits [m], infinite without a surface; `picture` is red, green and blue,
    one byte each, empty for a mere depth camera.
    """

    width: int  # [pixels]
    height: int
    depths: bytes
    picture: bytes = b""


class SeenEntity(Message):
    """Entity in a picture: its box [pixels], without the right column and lower row, and its pixels."""

    entity: str
    left: int
    top: int
    right: int
    bottom: int
    pixels: int


class SegmentationSample(Message):
    """Entity of each pixel, by row from the top.

    `labels` are little-endian integers of 16 bits: 0 for nothing, otherwise the place in `names`, from 1.
    """

    width: int  # [pixels]
    height: int
    labels: bytes
    names: tuple[str, ...]
    seen: tuple[SeenEntity, ...]  # without the floor


class WrenchSample(Message):
    """Load on a force-torque sensor: force [N] and torque about its origin [N m], in the frame of its link."""

    force: Vector3
    torque: Vector3


class NavSatFix(Message):
    """Position by satellite: degrees north and east, and metres above the ellipsoid (WGS 84)."""

    latitude: float
    longitude: float
    altitude: float


class SensorSample(Message):
    """Latest sample and its time [s]; exactly one of the other fields is set."""

    time: float
    lidar: LaserScan | None = None
    odometry: OdometrySample | None = None
    imu: ImuSample | None = None
    bumper: BumperSample | None = None
    cloud: PointCloud | None = None
    echo: RangeSample | None = None
    depth: DepthSample | None = None
    segmentation: SegmentationSample | None = None
    wrench: WrenchSample | None = None
    fix: NavSatFix | None = None


class WatchSensor(TrackedRequest):
    """Report when the next sample of a sensor arrives."""

    robot: str
    sensor: str


class WatchBumper(TrackedRequest):
    """Report when an entity presses a zone of a robot's bumper; empty names match any zone or entity."""

    robot: str
    zone: str = ""
    entity: str = ""


class WatchRange(TrackedRequest):
    """Report when a range of a sensor between two bearings [rad] is below `distance` [m]."""

    robot: str
    sensor: str
    distance: float
    start: float
    end: float


class WatchForce(TrackedRequest):
    """Report when the force that a force-torque sensor measures exceeds `force` [N]."""

    robot: str
    sensor: str
    force: float


class WatchSight(TrackedRequest):
    """Report when a segmentation sensor sees an entity, on at least `share` of its picture."""

    robot: str
    sensor: str
    entity: str
    share: float = 0.0


class CheckRate(TrackedRequest):
    """Count the samples of a sensor within `duration` [s]; aborted if their rate is out of bounds.

    Bounds are inclusive, in samples per second.
    """

    robot: str
    sensor: str
    lowest: float
    highest: float
    duration: float


GET_SENSOR_SAMPLE = Query("get_sensor_sample", SensorName, SensorSample)
WATCH_SENSOR = Verb("watch_sensor", WatchSensor, Empty)
WATCH_BUMPER = Verb("watch_bumper", WatchBumper, Empty)
WATCH_RANGE = Verb("watch_range", WatchRange, Empty)
WATCH_FORCE = Verb("watch_force", WatchForce, Empty)
WATCH_SIGHT = Verb("watch_sight", WatchSight, Empty)
CHECK_RATE = Verb("check_rate", CheckRate, Empty)
