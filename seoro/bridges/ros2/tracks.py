"""Poses of the robots of a ROS 2 system for the trace, by its transforms and odometry; see `Tracks`."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Final

import anyio
from anyio.abc import TaskGroup

from seoro.bridges.pose_reports import PoseReports
from seoro.bridges.ros2.errors import WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.tf.listener import MOVING, STATIC, WAITING
from seoro.bridges.ros2.tf.robots import ODOMETRY, TRANSFORMS, UNNAMED, RobotFrames, home_of, namespace_of
from seoro.bridges.ros2.wire import Qos, Reliability
from seoro.runtime.contracts.tracks import TrackReporter

MAX_TOPICS: Final = 200  # followed topics
SENSED: Final = Qos(reliability=Reliability.BEST_EFFORT, depth=5)
PATIENCE: Final = 1.0  # [s] for transforms, before the odometry of a namespace is followed
CLOCK: Final = "/clock"
_QOS: Final = {"tf": MOVING, "tf_static": STATIC, "odom": SENSED}  # by the last name of topics
_TYPES: Final = {"tf": TRANSFORMS, "tf_static": TRANSFORMS, "odom": ODOMETRY}


class RosTracks:
    """Follows the robots of a system.

    Args:
        node: Node of seoro.
        actors: Names of the robots of the scenario; a single one names a robot without a namespace.
        on_note: Called with invalid data.
    """

    def __init__(self, node: RosNode, actors: list[str], on_note: Callable[[str], None]) -> None:
        self._node = node
        self._actors = actors
        self._on_note = on_note
        self._frames: dict[str, RobotFrames] = {}  # by namespace
        self._followed: set[str] = set()  # topics
        self._namespaces: set[str] = set()  # with transforms
        self._silent_since: dict[str, float] = {}  # odometry without transforms, by the machine's clock [s]

    async def run(self, rate: float, report: TrackReporter) -> None:
        """Report poses until cancelled.

        Args:
            rate: Samples per second of the machine's clock [1/s].
            report: Called with each sample.
        """
        are_real = not self._node.graph.publishers(CLOCK)
        reports = PoseReports(report, are_real=are_real)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._follow, tasks)
            due = time.monotonic()
            while True:
                self._sample(reports)
                now = time.monotonic()
                due = max(due + 1.0 / rate, now)
                await anyio.sleep(due - now)

    def _sample(self, reports: PoseReports) -> None:
        for frames in self._frames.values():
            for robot in frames.robots():
                name = robot.name
                if name == UNNAMED and len(self._actors) == 1:
                    name = self._actors[0]
                reports.add(name, (*robot.pose.translation, *robot.pose.rotation), robot.frame)

    async def _follow(self, tasks: TaskGroup) -> None:
        """Subscribe to transforms as they appear, and to odometry where transforms are missing."""
        while True:
            new: list[str] = []
            with anyio.move_on_after(PATIENCE):
                new = await self._node.graph.wait_for(self._new_topics)
            for topic in new:
                self._followed.add(topic)
                tasks.start_soon(self._listen, topic)

    def _new_topics(self, graph: RosGraph) -> list[str]:
        topics = [
            topic
            for topic, types in graph.topics().items()
            if _TYPES.get(_last(topic)) in types and graph.publishers(topic)
        ]
        self._namespaces = {namespace_of(topic) for topic in topics if _last(topic) != "odom"}
        new = [topic for topic in topics if topic not in self._followed]
        found = [topic for topic in new if _last(topic) != "odom" or self._needs_odometry(topic)]
        return found[: MAX_TOPICS - len(self._followed)]

    def _needs_odometry(self, topic: str) -> bool:
        frames = self._frames.get(home_of(topic, self._namespaces))
        if frames is not None and frames.has_transforms:
            self._silent_since.pop(topic, None)
            return False
        now = time.monotonic()
        return now - self._silent_since.setdefault(topic, now) >= PATIENCE

    async def _listen(self, topic: str) -> None:
        last, namespace = _last(topic), home_of(topic, self._namespaces)
        frames = self._frames.setdefault(namespace, RobotFrames(namespace, self._on_note))
        put: Callable[[Any], None] = frames.put_odometry
        if last != "odom":

            def put(message: Any) -> None:
                frames.put_transforms(message, is_static=last == "tf_static")

        try:
            async with self._node.subscribing(topic, _TYPES[last], _QOS[last], WAITING, is_checked=False) as found:
                async for _, message in found.decoded(self._on_note):
                    put(message)
        except WrongType as error:
            self._on_note(str(error))


def _last(topic: str) -> str:
    return topic.rpartition("/")[2]
