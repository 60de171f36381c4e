"""Streams: samples, poses and joints that a node publishes while time passes.

A client subscribes to `node_stream(...)` first and then opens the stream of that name. The node then publishes a
`StreamUpdate` in each tick of 20 ms, while playing, in grants and in steps. A stream ends when its client closes
it, or ends its subscription. It continues in another world, for robots of the same names.
"""

from __future__ import annotations

from seoro.bridges.wire.arms import JointStates
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.sensors import SensorName, SensorSample
from seoro.robotics.geometry import Pose3D


class OpenStream(Message):
    """Publish the time and the listed data under the name of the stream.

    Samples of `sensors` are published on arrival. `poses`, `joints` and `batteries` are names of robots, whose
    estimated poses, joints and batteries are published. `cameras` are names of cameras, whose pictures are
    published at 10 Hz. Sensors and cameras are rendered only while a stream, or another client, uses them.
    """

    id: str
    sensors: tuple[SensorName, ...] = ()
    poses: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    batteries: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()


class StreamName(Message):
    """A stream by the name that its client chose."""

    id: str


class StreamedSample(Message):
    """Sample of a sensor of a robot."""

    robot: str
    sensor: str
    sample: SensorSample


class StreamedPose(Message):
    """Estimated pose of a robot: its base and its frame `odom`, in `map`.

    `deviation` is the standard deviation of its position [m].
    """

    robot: str
    base: Pose3D
    odom: Pose3D
    deviation: float


class StreamedJoints(Message):
    """Joints of the arm, gripper and wheels of a robot."""

    robot: str
    joints: JointStates


class StreamedBattery(Message):
    """Charge of a robot's battery, from 0 to 1."""

    robot: str
    charge: float


class StreamedPicture(Message):
    """Picture of a camera at `time` [s], with its injected faults.

    `pixels` are red, green and blue, one byte each, by row from the top.
    """

    camera: str
    time: float
    width: int  # [pixels]
    height: int
    pixels: bytes


class StreamUpdate(Message):
    """Content of a stream at a tick. `number` counts from 1, so that receivers detect losses."""

    number: int
    time: float
    samples: tuple[StreamedSample, ...] = ()
    poses: tuple[StreamedPose, ...] = ()
    joints: tuple[StreamedJoints, ...] = ()
    batteries: tuple[StreamedBattery, ...] = ()
    pictures: tuple[StreamedPicture, ...] = ()


OPEN_STREAM = Verb("open_stream", OpenStream, Empty)
CLOSE_STREAM = Verb("close_stream", StreamName, Empty)
