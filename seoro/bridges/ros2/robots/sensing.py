"""Force-torque sensors and detectors of a robot: watches of their messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.link import DISCOVERY_TIMEOUT, RobotLink
from seoro.bridges.ros2.robots.profile import Detector, Sensors
from seoro.bridges.serving.robot import Carry, Handlers
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_positive, name_list

WRENCH, DETECTIONS = "geometry_msgs/msg/WrenchStamped", "vision_msgs/msg/Detection2DArray"


class Topic:
    """Latest message of a sensor.

    Args:
        link: Link to the robot.
        name: Name of the topic.
        type_name: Type of its messages.
        check: Raises `ValueError` for an invalid message, which is dropped.
    """

    def __init__(self, link: RobotLink, name: str, type_name: str, check: Callable[[Message], None]) -> None:
        self._link = link
        self._name = name
        self._type_name = type_name
        self._check = check
        self._latest: Message | None = None
        self._watches: set[Callable[[Message], None]] = set()

    async def open(self) -> None:
        """Subscribe to the topic."""
        await self._link.listen(self._name, self._type_name, self._on_message, forget=self._forget)

    def _forget(self) -> None:
        """Forget the latest message: its publisher has disappeared."""
        self._latest = None

    def _on_message(self, message: Message) -> None:
        self._forget()
        self._check(message)
        self._latest = message
        for look in tuple(self._watches):  # at each message: a short peak may pass before a task resumes
            look(message)

    async def start_watch(self, request: wire.TrackedRequest, holds: Callable[[Message], bool]) -> None:
        """Report the first message for which a condition holds, from the latest one on.

        Raises:
            RequestRefused: The topic has no valid message.
        """
        with anyio.move_on_after(DISCOVERY_TIMEOUT):
            await self._link.intake.arrivals.wait_for(lambda: self._latest is not None)
        if self._latest is None:
            topic, why = self._link.node.resolve(self._name), self._link.explain_silence(self._name)
            raise RequestRefused(Result.INCORRECT_STATE, f"no measurement of the robot on {topic}: {why}")

        self._link.work.start(request.id, partial(self._wait, holds))

    async def _wait(self, holds: Callable[[Message], bool]) -> str:
        is_seen = False

        def look(message: Message) -> None:
            nonlocal is_seen
            is_seen = is_seen or holds(message)

        if self._latest is not None:
            look(self._latest)
        self._watches.add(look)
        try:
            await self._link.intake.arrivals.wait_for(lambda: is_seen)
        finally:
            self._watches.discard(look)
        return ""


class Sensing:
    """Sensors of a robot.

    Args:
        link: Link to the robot.
        sensors: Topics of its sensors.
    """

    def __init__(self, link: RobotLink, sensors: Sensors) -> None:
        self._link = link
        self._sensors = sensors
        self._force = {
            name: Topic(link, topic, WRENCH, partial(_check_wrench, link.node.resolve(topic)))
            for name, topic in sensors.force.items()
        }
        self._sight = {
            name: Topic(link, each.topic, DETECTIONS, lambda _: None) for name, each in sensors.sight.items()
        }

    @property
    def handlers(self) -> Handlers:
        """Handlers of the verbs for which the robot has a sensor."""
        served: dict[wire.Verb[Any, Any], Carry] = {}
        if self._force:
            served[wire.WATCH_FORCE] = self._watch_force
        if self._sight:
            served[wire.WATCH_SIGHT] = self._watch_sight
        return served

    async def open(self) -> None:
        """Subscribe to the topics."""
        for topic in (*self._force.values(), *self._sight.values()):
            await topic.open()

    async def _watch_force(self, request: wire.WatchForce) -> None:
        check_positive("force", request.force, "N")
        self._check_name("force-torque sensor", request.sensor, self._force)
        await self._force[request.sensor].start_watch(request, lambda message: force_of(message) > request.force)

    async def _watch_sight(self, request: wire.WatchSight) -> None:
        self._check_name("detector", request.sensor, self._sight)
        detector = self._sensors.sight[request.sensor]
        if not 0.0 <= request.share <= 1.0:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"invalid share {request.share}; expected a number from 0 to 1"
            )
        if request.share and detector.area is None:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"the size of the pictures of '{request.sensor}' is unknown; add `width` and `height` to its "
                "detector in the profile of the robot, or omit `share`",
            )
        await self._sight[request.sensor].start_watch(request, partial(sees, detector, request))

    def _check_name(self, kind: str, name: str, known: Collection[str]) -> None:
        if name not in known:
            raise RequestRefused(
                Result.NOT_FOUND,
                f"unknown {kind} '{name:.100}' (in the profile of '{self._link.name}': {name_list(known)})",
            )


def _check_wrench(topic: str, message: Message) -> None:
    """Refuse a force that is not finite.

    Raises:
        ValueError: A component is NaN or infinite.
    """
    if not math.isfinite(force_of(message)):
        raise ValueError(f"invalid wrench on {topic}: its force is not finite")


def force_of(message: Message) -> float:
    """Return the magnitude of the force of a `geometry_msgs/WrenchStamped` [N]."""
    force = message.wrench.force
    return math.hypot(force.x, force.y, force.z)


def sees(detector: Detector, request: wire.WatchSight, message: Message) -> bool:
    """Whether a `vision_msgs/Detection2DArray` has the entity of a request, on the share of the picture.

    A detection counts by its id, or by a class whose score is high enough. Its box stands for its pixels.
    """
    return any(
        _is_named(each, request.entity, detector.lowest_score)
        and (detector.area is None or each.bbox.size_x * each.bbox.size_y >= request.share * detector.area)
        for each in message.detections
    )


def _is_named(detection: Message, name: str, lowest_score: float) -> bool:
    hypotheses = [each.hypothesis for each in detection.results]
    if not hypotheses:
        return bool(detection.id == name)
    return any(name in (each.class_id, detection.id) and each.score >= lowest_score for each in hypotheses)
