"""Streams: what nodes publish by themselves while time passes, once they were asked to.

A client subscribes to `node_stream(...)` first and then opens the stream of that name. From then on the node
publishes a `Streamed` in each tick of 20 ms, while it plays as well as in grants and steps. A stream ends when its
client closes it, or has no subscription any more. It goes on when another world is loaded, with the robots of the
same names.
"""

from __future__ import annotations

from seoro.bridges.wire.arms import JointStates
from seoro.bridges.wire.geometry import Pose
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.sensors import SensorName, SensorSample


class OpenStream(Message):
    """Publish the time, and what else is listed, under the name of the stream.

    `sensors` are those whose samples are published when they arrive; `poses`, `joints` and `batteries` are the
    robots of which it is published where they believe they are, and how their joints and their batteries are.
    """

    id: str
    sensors: tuple[SensorName, ...] = ()
    poses: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    batteries: tuple[str, ...] = ()


class StreamName(Message):
    """A stream by the name that its client gave it."""

    id: str


class StreamedSample(Message):
    """A sample that has arrived from a sensor of a robot."""

    robot: str
    sensor: str
    sample: SensorSample


class StreamedPose(Message):
    """Where a robot believes that it is: its base and its frame `odom`, in `map`.

    `deviation` [m] is how far off it takes its position to be, as a standard deviation.
    """

    robot: str
    base: Pose
    odom: Pose
    deviation: float


class StreamedJoints(Message):
    """The joints of a robot: those of its arm and gripper, and its wheels."""

    robot: str
    joints: JointStates


class StreamedBattery(Message):
    """The charge of a robot's battery, from 0 to 1."""

    robot: str
    charge: float


class Streamed(Message):
    """What a stream has to tell of a tick. `number` counts from 1, so that losses are noticed."""

    number: int
    time: float
    samples: tuple[StreamedSample, ...] = ()
    poses: tuple[StreamedPose, ...] = ()
    joints: tuple[StreamedJoints, ...] = ()
    batteries: tuple[StreamedBattery, ...] = ()


OPEN_STREAM = Verb("open_stream", OpenStream, Empty)
CLOSE_STREAM = Verb("close_stream", StreamName, Empty)
