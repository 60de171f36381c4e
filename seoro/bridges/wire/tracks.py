"""Tracks: samples of poses that a simulator adds to its answers to grants."""

from __future__ import annotations

from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.scene import Scene, SceneEntity

POSE_VALUES = 13  # of an entity: position, quaternion (x, y, z, w), linear and angular velocity
LINK_VALUES = 7  # of a link: position and quaternion (x, y, z, w)
BELIEVED_VALUES = 3  # of a robot: x, y, yaw
MAX_PLAN = 500  # points of a plan
MAX_BEAMS = 100_000  # of a scan


class StartTracks(Message):
    """Sample poses while time passes from now on, at a rate in samples per simulated second; 0 ends it.

    The period is rounded to whole ticks of 20 ms. `scans` are the scans of each planar lidar per simulated second,
    at most `rate`; 0 for none. Samples do not change the simulation.
    """

    rate: float
    scans: float = 0.0


class TrackPlan(Message):
    """Plan of a robot: x, y of its points as little-endian doubles [m], in `map`; empty without a plan."""

    robot: str
    points: bytes = b""


class TrackLinks(Message):
    """Links of a robot that moved against its base.

    `poses` has 7 little-endian doubles per link: x, y, z [m] and quaternion x, y, z, w, in the frame of the robot.
    """

    robot: str
    links: tuple[str, ...]
    poses: bytes


class TrackScan(Message):
    """Scan of a planar lidar, with its injected faults.

    `mount` has x, y, z [m] of the lidar in the frame of the robot, whose axes its bearings have. `ranges` are
    little-endian floats of 32 bits [m], infinite without a hit.
    """

    robot: str
    sensor: str
    mount: tuple[float, float, float]
    first: float  # bearing of the first beam [rad]
    step: float  # between two beams, to the left [rad]
    ranges: bytes


class TrackSample(Message):
    """Poses at a time. The first sample has all robots and movable entities, later ones the moved entities.

    `poses` has 13 little-endian doubles per entity: x, y, z [m], quaternion x, y, z, w, linear [m/s] and angular
    [rad/s] velocity, in `map`. `believed` has 3 per robot: x, y [m] and yaw [rad] of its localisation.
    """

    time: float
    entities: tuple[str, ...] = ()
    poses: bytes = b""
    localised: tuple[str, ...] = ()
    believed: bytes = b""
    removed: tuple[str, ...] = ()  # entities that were deleted since the sample before
    added: tuple[SceneEntity, ...] = ()  # entities that were spawned since then
    scene: Scene | None = None  # another world since then
    plans: tuple[TrackPlan, ...] = ()  # of robots that have planned again, at most once per second each
    scans: tuple[TrackScan, ...] = ()
    moved_links: tuple[TrackLinks, ...] = ()


START_TRACKS = Verb("start_tracks", StartTracks, Empty)
