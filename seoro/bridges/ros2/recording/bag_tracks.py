"""Poses of recorded robots for the trace of a run, by their transforms and odometry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from seoro.bridges.pose_reports import PoseReports
from seoro.bridges.ros2.interfaces import InvalidPayload, TypeStore
from seoro.bridges.ros2.recording.bag_clock import SECOND
from seoro.bridges.ros2.recording.metadata import BagMessage
from seoro.bridges.ros2.recording.reader import Bag
from seoro.bridges.ros2.tf.robots import ODOMETRY, TRANSFORMS, UNNAMED, RobotFrames, namespace_of
from seoro.errors import UsageError
from seoro.runtime.contracts.tracks import TrackReporter

TYPES: Final = {"tf": TRANSFORMS, "tf_static": TRANSFORMS, "odom": ODOMETRY}  # by the last name of topics


class BagTracks:
    """Samples of the poses of recorded robots.

    Args:
        bag: The bag.
        robots: Namespaces by the names of robots; empty for the root.
        definitions: Returns the definitions of a topic.
        rate: Samples per second of the bag [1/s].
        report: Called with each sample.
    """

    def __init__(
        self,
        bag: Bag,
        robots: Mapping[str, str],
        definitions: Callable[[str], TypeStore],
        rate: float,
        report: TrackReporter,
    ) -> None:
        self._names = {namespace: name for name, namespace in robots.items()}
        self._definitions = definitions
        self._reports = PoseReports(report, are_real=True)
        self._frames = {namespace: RobotFrames(namespace) for namespace in self._names}
        topics = [name for name, each in bag.topics.items() if self._is_followed(name, each.type)]
        self._messages = bag.messages(topics) if topics else iter(())
        self._next: BagMessage | None = None
        self._start = self._due = bag.extent.start
        self._end = bag.extent.end if topics else self._start - 1
        self._period = round(SECOND / rate)

    def _is_followed(self, topic: str, type_name: str) -> bool:
        return namespace_of(topic) in self._frames and TYPES.get(topic.rpartition("/")[2]) == type_name

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
        last, frames = message.topic.rpartition("/")[2], self._frames[namespace_of(message.topic)]
        try:
            decoded = self._definitions(message.topic).decode(TYPES[last], message.payload)
        except (InvalidPayload, UsageError):
            return  # actions that observe the topic report it
        if last == "odom":
            frames.put_odometry(decoded)
        else:
            frames.put_transforms(decoded, is_static=last == "tf_static")

    def _sample(self, at: float) -> None:
        for namespace, frames in self._frames.items():
            for robot in frames.robots():
                name = self._names[namespace] if robot.name in (namespace, UNNAMED) else robot.name
                self._reports.add(name, (*robot.pose.translation, *robot.pose.rotation), robot.frame, at)
