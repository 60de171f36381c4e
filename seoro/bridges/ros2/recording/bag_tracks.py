"""Poses of recorded robots for the trace of a run, by their transforms and odometry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from seoro.bridges.pose_reports import PoseReports
from seoro.bridges.ros2.interfaces import InvalidPayload, TypeStore
from seoro.bridges.ros2.recording.bag_clock import SECOND
from seoro.bridges.ros2.recording.metadata import BagMessage
from seoro.bridges.ros2.recording.reader import Bag
from seoro.bridges.ros2.tf.robots import ODOMETRY, TRANSFORMS, UNNAMED, RobotFrames
from seoro.errors import UsageError
from seoro.runtime.contracts.ros2 import RobotNames
from seoro.runtime.contracts.tracks import TrackReporter

STATIC: Final = "tf_static"  # last name of topics


class BagTracks:
    """Samples of the poses of recorded robots.

    Args:
        bag: The bag.
        robots: Names of their topics, by the names of the robots.
        definitions: Returns the definitions of a topic.
        rate: Samples per second of the bag [1/s].
        report: Called with each sample.
    """

    def __init__(
        self,
        bag: Bag,
        robots: Mapping[str, RobotNames],
        definitions: Callable[[str], TypeStore],
        rate: float,
        report: TrackReporter,
    ) -> None:
        self._names: dict[str, dict[str, str]] = {}  # of robots, by the namespaces of their frames and their own
        self._frames: dict[str, RobotFrames] = {}  # by their namespaces
        self._followed: dict[str, tuple[str, str]] = {}  # types and namespaces of frames, by topics
        for name, names in robots.items():
            self._follow(name, names, bag)
        self._definitions = definitions
        self._reports = PoseReports(report, are_real=True)
        topics = list(self._followed)
        self._messages = bag.messages(topics) if topics else iter(())
        self._next: BagMessage | None = None
        self._start = self._due = bag.extent.start
        self._end = bag.extent.end if topics else self._start - 1
        self._period = round(SECOND / rate)

    def _follow(self, robot: str, names: RobotNames, bag: Bag) -> None:
        space = names.frames
        self._names.setdefault(space, {})[names.namespace] = robot
        self._frames.setdefault(space, RobotFrames(space))
        topics = {
            names.full(names.tf): TRANSFORMS,
            RobotNames(space).full(STATIC): TRANSFORMS,
            names.full(names.odometry): ODOMETRY,
        }
        for topic, type_ in topics.items():
            if topic in bag.topics and bag.topics[topic].type == type_:
                self._followed[topic] = (type_, space)

    def advance(self, until: int) -> None:
        """Report the samples up to a time [ns since the epoch].

        Raises:
            UnreadableBag: A file of the bag is damaged.
        """
        while self._due <= min(until, self._end):
            while (message := self._next or next(self._messages, None)) is not None:
                self._next = message if message.received > self._due else None
                if self._next is not None:
                    break
                self._put(message)
            self._sample((self._due - self._start) / SECOND)
            self._due += self._period

    def _put(self, message: BagMessage) -> None:
        type_, space = self._followed[message.topic]
        frames = self._frames[space]
        try:
            decoded = self._definitions(message.topic).decode(type_, message.payload)
        except (InvalidPayload, UsageError):
            return  # actions that observe the topic report it
        if type_ == ODOMETRY:
            frames.put_odometry(decoded)
        else:
            frames.put_transforms(decoded, is_static=message.topic.endswith(f"/{STATIC}"))

    def _sample(self, at: float) -> None:
        for space, frames in self._frames.items():
            for robot in frames.robots():
                name = self._name_of(robot.name, space)
                self._reports.add(name, (*robot.pose.translation, *robot.pose.rotation), robot.frame, at)

    def _name_of(self, found: str, space: str) -> str:
        """Return the name of a robot, by that of its prefix or namespace."""
        names = self._names[space]
        if found in names:
            return names[found]
        return next(iter(names.values())) if len(names) == 1 and found in (space, UNNAMED) else found
