"""Output of runs: artifacts, measurements and video recordings."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.bridges.wire.limits import BYTES
from seoro.bridges.wire.message import Empty, Message, Query, Verb


class Artifact(Message):
    """A file for the output folder of a run."""

    name: str
    media_type: str
    description: str
    data: bytes


class Artifacts(Message):
    """Artifacts of the run up to now."""

    artifacts: tuple[Artifact, ...]


class RobotMeasurements(Message):
    """Measurements of a robot, since the world was loaded or reset.

    Those of driving, localisation and goals are 0 or null for robots that do not drive.

    Errors of the localisation are distances between the estimated and the true position, in every tick of 20 ms
    with a pose; `localisation_error_driving` counts only ticks with motion.
    """

    path_length: float  # [m] true length
    driving_time: float  # [s] in motion
    localisation_error: float | None  # mean [m]
    localisation_error_driving: float | None  # mean [m]
    localisation_error_max: float | None  # [m]
    localisation_deviation: float | None  # mean of the standard deviation stated by the localisation [m]
    closest_approach: float | None  # distance of its outline to any entity, from above [m]; None without any
    contacts: int
    goals_reached: int
    goals_aborted: int
    goals_canceled: int
    recoveries: int
    closest_entity: str = ""  # entity of the closest approach
    max_speed: float = 0.0  # true speed in the plane [m/s]
    mean_speed: float | None = None  # mean true speed while moving [m/s]; None if it never moved
    contacts_with: Mapping[str, int] = {}  # number of contacts by entity
    time_in: Mapping[str, float] = {}  # time in the room of each named pose that has one [s]
    energy: float | None = None  # drawn from the battery [J]; None without one
    smoothness: float | None = None  # log dimensionless jerk of the speed; nearer to 0 is smoother
    path_efficiency: float | None = None  # success weighted by path length, 0 to 1; None without an ended goal
    work: float | None = None  # mechanical work of the motors [J]; None if the engine does not know it


class EntityMeasurements(Message):
    """Measurements of a movable entity since it exists.

    It is sampled every 0.1 s, or every second while all robots are at rest. Contacts are exact.
    """

    path_length: float  # in the plane [m]
    max_speed: float  # in the plane [m/s]
    contacts: int
    contacts_with: Mapping[str, int]
    time_in: Mapping[str, float]  # time in the room of each named pose that has one [s]


class Measurements(Message):
    """Measurements of a run up to a time [s], by robot and by movable entity."""

    world: str
    engine: str
    engine_version: str
    seed: int
    time: float
    robots: Mapping[str, RobotMeasurements]
    entities: Mapping[str, EntityMeasurements] = {}


class StartRecording(Message):
    """Start the recording of a film, one at a time: of a camera, a followed robot, or the whole world.

    Recording continues through resets and in another world of the same run, and ends when a world is loaded anew.
    """

    camera: str = ""
    follow: str = ""  # name of a robot or a spawned entity
    width: int = 640  # [pixels]; cameras have their own size
    height: int = 360
    rate: int = 25  # pictures per second of simulated time [Hz]


class RecordingEnd(Message):
    """Last part of a film, and the reason of an early end."""

    film: bytes
    error: str = ""


GET_ARTIFACTS = Query("get_artifacts", Empty, Artifacts, reply_limits=BYTES)
GET_MEASUREMENTS = Query("get_measurements", Empty, Measurements)
START_RECORDING = Verb("start_recording", StartRecording, Empty)
STOP_RECORDING = Verb("stop_recording", Empty, RecordingEnd, reply_limits=BYTES)
