"""Link to a ROS 2 robot: a node of the bridge in its namespace, with its topics and services."""

from __future__ import annotations

import logging
import time
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from anyio.abc import TaskGroup

from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.errors import CallFailed, DefinitionMismatch, NoServiceServer, WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import InvalidPayload, Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.robots.frames import Frames
from seoro.bridges.ros2.robots.guard_state import GuardState
from seoro.bridges.ros2.robots.intake import Intake
from seoro.bridges.ros2.topics import Publication, ReceivedPayload, Subscription
from seoro.bridges.ros2.wire import Qos, Reliability
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.work import Work
from seoro.bridges.session import Bound
from seoro.bridges.wire import Result, TopicState
from seoro.bridges.wire.refusal import RequestRefused

SENSED = Qos(reliability=Reliability.BEST_EFFORT, depth=5)
WAITING = Bound(1000)  # queue of a topic, which is read every 0.2 s
DISCOVERY_TIMEOUT = 5.0  # [s] for endpoints and messages that a request needs
ANSWER_TIMEOUT = 5.0  # [s] for the response of a service
SECOND = 1e9  # [ns]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Link:
    """Link to a robot.

    Attributes:
        node: Node in the namespace of the robot.
        stack: Stack that is closed when the bridge ends.
        tasks: Task group of the subscriptions.
        state: State that the bridge shares with its guard.
        intake: Messages of the subscribed topics.
    """

    node: RosNode
    stack: AsyncExitStack
    tasks: TaskGroup
    state: GuardState = field(default_factory=GuardState)
    intake: Intake = field(default_factory=Intake, repr=False)
    _statuses: dict[str, _TopicStatus] = field(default_factory=dict, repr=False)

    async def listen(
        self,
        topic: str,
        type_name: str,
        take: Callable[[Message], None],
        qos: Qos = SENSED,
        forget: Callable[[], None] | None = None,
    ) -> None:
        """Subscribe to a topic until the bridge ends; log once if its publishers have another type.

        Args:
            topic: Name of the topic.
            type_name: Type of the messages.
            take: Called with each message.
            qos: Requested QoS profile.
            forget: Called whenever the last publisher of the topic disappears.
        """
        subscription = await self.stack.enter_async_context(
            self.node.subscribing(topic, type_name, qos, WAITING, is_checked=False)
        )
        status = self._statuses[subscription.topic] = _TopicStatus(subscription.type, qos)
        if len(self._statuses) == 1:
            self.tasks.start_soon(self.intake.run)
        self.intake.add(subscription, partial(self._take, subscription, take, status))
        self.tasks.start_soon(self._warn_of_type, subscription.topic, status.type)
        if forget is not None:
            self.tasks.start_soon(self._watch_end, subscription.topic, forget)

    def _take(
        self,
        subscription: Subscription,
        take: Callable[[Message], None],
        status: _TopicStatus,
        received: ReceivedPayload,
    ) -> None:
        """Forward a message. Log undecodable messages once per kind."""
        status.note_arrival(received)
        try:
            message = subscription.decode(received)
            take(message)
        except (InvalidPayload, DefinitionMismatch, WrongType, ValueError) as error:
            if type(error).__name__ not in status.logged:
                log.warning("%s", error)
            status.logged.add(type(error).__name__)
            status.error = str(error)
        else:
            status.error, status.latest = "", message

    async def _warn_of_type(self, topic: str, type_name: str) -> None:
        """Log once if a topic has another type."""

        def is_other(graph: RosGraph) -> bool:
            types = {publisher.type for publisher in graph.publishers(topic)}
            return bool(types) and type_name not in types

        await self.node.graph.wait_for(is_other)
        log.warning("%s: %s", topic, self.explain_silence(topic))

    async def _watch_end(self, topic: str, forget: Callable[[], None]) -> None:
        """Call `forget` whenever the last publisher of a topic disappears, without end."""
        graph = self.node.graph
        while True:
            await graph.wait_for(lambda seen: seen.publishers(topic))
            await graph.wait_for(lambda seen: not seen.publishers(topic))
            self.intake.read()
            forget()
            self.intake.arrivals.notify_all()

    def explain_silence(self, topic: str) -> str:
        """Explain why a topic has no usable messages, as far as known."""
        name = self.node.resolve(topic)
        status, publishers = self._statuses[name], self.node.graph.publishers(name)
        types = sorted({publisher.type for publisher in publishers} - {status.type})
        if not publishers:
            return "no publisher"
        if types:
            return f"it has the type {' and '.join(types)}, not {status.type}"
        return status.error or "no message has arrived"

    def is_silent(self, topic: str, period: float) -> bool:
        """Return whether a subscribed topic had no message within a period [s] until now."""
        arrived = self._status(topic).arrived
        return arrived is None or time.monotonic() - arrived > period

    def error_of(self, topic: str) -> str:
        """Return the error of the last message of a subscribed topic; empty if it is valid."""
        return self._status(topic).error

    def latest(self, topic: str) -> Message | None:
        """Return the last valid message of a subscribed topic."""
        return self._status(topic).latest

    def qos_of(self, topic: str) -> Qos | None:
        """Return the requested QoS profile of a topic; None if it is not subscribed."""
        status = self._statuses.get(self.node.resolve(topic))
        return None if status is None else status.qos

    def clock_offsets(self) -> dict[str, float]:
        """Return by topics how far the clocks of publishers are ahead of that of this machine [s], if known."""
        return {name: each.offset for name, each in self._timely() if each.offset is not None}

    def stamps(self) -> dict[str, tuple[float, float]]:
        """Return the stamps and arrivals of the last messages with a header, by topics [s since 1970]."""
        return {
            name: (geometry.seconds(each.latest.header.stamp), each.arrived_at)
            for name, each in self._timely()
            if each.latest is not None and hasattr(each.latest, "header")
        }

    def _timely(self) -> Iterator[tuple[str, _TopicStatus]]:
        """Yield the topics whose messages arrive when they are sent: latched ones may be old."""
        return ((name, each) for name, each in self._statuses.items() if not each.qos.is_transient_local)

    def _status(self, topic: str) -> _TopicStatus:
        return self._statuses[self.node.resolve(topic)]

    def last_received(self) -> float | None:
        """Return the age of the last message on any topic [s]; None before the first message."""
        arrivals = [status.arrived for status in self._statuses.values() if status.arrived is not None]
        return time.monotonic() - max(arrivals) if arrivals else None

    def topics(self) -> tuple[TopicState, ...]:
        """Return the states of the subscribed topics."""
        return tuple(self._topic_state(topic, status) for topic, status in self._statuses.items())

    def _topic_state(self, topic: str, status: _TopicStatus) -> TopicState:
        is_well = status.arrived is not None and not status.error and self.node.graph.publishers(topic)
        return TopicState(
            topic=topic,
            seen=None if status.arrived is None else time.monotonic() - status.arrived,
            why="" if is_well else self.explain_silence(topic),
        )

    async def publish(self, topic: str, type_name: str) -> tuple[Publication, Callable[[], Awaitable[None]]]:
        """Create a publisher until the bridge ends; return it with a function that closes it earlier."""
        async with AsyncExitStack() as opening:
            publication = await opening.enter_async_context(self.node.publishing(topic, type_name))
            close = opening.pop_all().aclose
        self.stack.push_async_callback(close)
        return publication, close

    async def call(self, service: str, type_name: str, request: Mapping[str, Any]) -> Message:
        """Call a service of the robot.

        Raises:
            RequestRefused: The service has no server or another type, or does not respond.
        """
        try:
            async with self.node.calling(service, type_name) as client:
                await client.wait_for_server(DISCOVERY_TIMEOUT)
                return await client.call(request, ANSWER_TIMEOUT)
        except NoServiceServer:
            message = f"no server of {self.node.resolve(service)} on the robot"
            raise RequestRefused(Result.INCORRECT_STATE, message) from None
        except (WrongType, DefinitionMismatch) as error:
            raise RequestRefused(Result.INCORRECT_STATE, str(error)) from error
        except CallFailed as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error


@dataclass(frozen=True, kw_only=True)
class RobotLink(Link):
    """Link to a robot that a node serves.

    Attributes:
        name: Name of the robot in scenarios.
        work: Goals and watches of the node.
        events: Log of events.
        frames: Frames of the robot.
    """

    name: str
    work: Work
    events: EventLog
    frames: Frames = field(default_factory=Frames)


@dataclass
class _TopicStatus:
    """Status of a topic: its type and requested QoS profile, and its last message.

    Attributes:
        error: Error of the last message; empty if it is valid.
        logged: Kinds of errors that were logged.
        arrived: Arrival of the last message, by the machine's clock [s].
        arrived_at: Arrival of the last message [s since 1970].
        offset: Time by which the sender's clock was ahead at its arrival [s]; None if unknown.
        latest: Last valid message.
    """

    type: str
    qos: Qos
    error: str = ""
    logged: set[str] = field(default_factory=set)
    arrived: float | None = None
    arrived_at: float = 0.0
    offset: float | None = None
    latest: Message | None = None

    def note_arrival(self, received: ReceivedPayload) -> None:
        """Note the arrival of a message."""
        self.arrived, self.arrived_at = time.monotonic(), received.arrived / SECOND
        self.offset = None if received.sent is None else (received.sent - received.arrived) / SECOND
