"""What a robot of ROS 2 is spoken to by: a node of the bridge in its namespace, and what is open for it."""

from __future__ import annotations

import logging
import time
from collections.abc import Awaitable, Callable, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from typing import Any

from anyio.abc import TaskGroup

from seoro.bridges.ros2.errors import CallFailed, DefinitionMismatch, NoServiceServer, WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import InvalidPayload, Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.robots.standstill import Standstills
from seoro.bridges.ros2.robots.unanswered import Unanswered
from seoro.bridges.ros2.topics import Publication, Subscription
from seoro.bridges.ros2.wire import Qos, Reliability
from seoro.bridges.session import Bound
from seoro.bridges.wire import Result, TopicState
from seoro.bridges.wire.refusal import RequestRefused

SENSED = Qos(reliability=Reliability.BEST_EFFORT, depth=5)
FOUND_WITHIN = 5.0  # [s] that what a request needs may take to appear
ANSWER_WITHIN = 5.0  # [s] that a service may take to respond

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Link:
    """The link to a robot.

    Attributes:
        node: A node in the namespace of the robot.
        stack: What is closed when the bridge ends.
        tasks: Where what listens runs.
        standstills: Of the bridge.
        unanswered: Goals that the bridge has sent, and that may be taken later.
    """

    node: RosNode
    stack: AsyncExitStack
    tasks: TaskGroup
    standstills: Standstills = field(default_factory=Standstills)
    unanswered: Unanswered = field(default_factory=Unanswered)
    _heard: dict[str, _Heard] = field(default_factory=dict, repr=False)

    async def listen(
        self, topic: str, type_name: str, take: Callable[[Message], None], qos: Qos = SENSED, keep: int = 100
    ) -> None:
        """Have each message of a topic taken, from now on; that others publish another type is said once."""
        subscription = await self.stack.enter_async_context(
            self.node.subscribing(topic, type_name, qos, Bound(keep), is_checked=False)
        )
        heard = self._heard[subscription.topic] = _Heard(subscription.type)
        self.tasks.start_soon(_take_all, subscription, take, heard)
        self.tasks.start_soon(self._warn_of_type, subscription.topic, heard.type)

    async def _warn_of_type(self, topic: str, type_name: str) -> None:
        """Say when a topic is of another type, once."""

        def is_other(graph: RosGraph) -> bool:
            types = {publisher.type for publisher in graph.publishers(topic)}
            return bool(types) and type_name not in types

        await self.node.graph.wait_for(is_other)
        log.warning("%s: %s", topic, self.why_silent(topic))

    async def watch_end(self, topic: str, forget: Callable[[], None]) -> None:
        """Have what a topic has told forgotten whenever nobody publishes it any more, without end."""
        graph, name = self.node.graph, self.node.resolve(topic)
        while True:
            await graph.wait_for(lambda seen: seen.publishers(name))
            await graph.wait_for(lambda seen: not seen.publishers(name))
            forget()

    def why_silent(self, topic: str) -> str:
        """Why nothing is known by a topic that is listened to, as far as that can be said."""
        name = self.node.resolve(topic)
        heard, publishers = self._heard[name], self.node.graph.publishers(name)
        types = sorted({publisher.type for publisher in publishers} - {heard.type})
        if not publishers:
            return "nobody publishes it"
        if types:
            return f"it is of type {' and '.join(types)}, not {heard.type}"
        return heard.unreadable or "no message has come"

    def heard_ago(self) -> float | None:
        """How long ago the robot was last heard of on any topic [s]; None when it never was."""
        moments = [heard.moment for heard in self._heard.values() if heard.moment is not None]
        return time.monotonic() - max(moments) if moments else None

    def topics(self) -> tuple[TopicState, ...]:
        """What is heard on each topic that is listened to."""
        return tuple(self._state(topic, heard) for topic, heard in self._heard.items())

    def _state(self, topic: str, heard: _Heard) -> TopicState:
        is_well = heard.moment is not None and not heard.unreadable and self.node.graph.publishers(topic)
        return TopicState(
            topic=topic,
            seen=None if heard.moment is None else time.monotonic() - heard.moment,
            why="" if is_well else self.why_silent(topic),
        )

    async def publish(self, topic: str, type_name: str) -> tuple[Publication, Callable[[], Awaitable[None]]]:
        """A publisher for as long as the bridge runs, and what closes it before."""
        async with AsyncExitStack() as opening:
            publication = await opening.enter_async_context(self.node.publishing(topic, type_name))
            close = opening.pop_all().aclose
        self.stack.push_async_callback(close)
        return publication, close

    async def call(self, service: str, type_name: str, request: Mapping[str, Any]) -> Message:
        """Call a service of the robot.

        Raises:
            RequestRefused: Nobody serves it, or it is of another type, or it does not respond.
        """
        try:
            async with self.node.calling(service, type_name) as client:
                await client.wait_for_server(FOUND_WITHIN)
                return await client.call(request, ANSWER_WITHIN)
        except (TimeoutError, NoServiceServer):
            raise RequestRefused(
                Result.INCORRECT_STATE, f"nobody on the robot serves {self.node.resolve(service)}"
            ) from None
        except (WrongType, DefinitionMismatch) as error:
            raise RequestRefused(Result.INCORRECT_STATE, str(error)) from error
        except CallFailed as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error


@dataclass
class _Heard:
    """What is heard on a topic: the type of its messages, when, and why the last cannot be read, if it cannot."""

    type: str
    unreadable: str = ""
    said: set[str] = field(default_factory=set)  # kinds of reasons why some could not be read
    moment: float | None = None  # of the last one, by the machine's clock [s]


async def _take_all(subscription: Subscription, take: Callable[[Message], None], heard: _Heard) -> None:
    """Pass messages on; what cannot be read is said once for each kind, and does not end the bridge."""
    async for received in subscription:
        heard.moment = time.monotonic()
        try:
            take(subscription.decode(received))
        except (InvalidPayload, DefinitionMismatch, WrongType, ValueError) as error:
            if type(error).__name__ not in heard.said:
                log.warning("%s", error)
            heard.said.add(type(error).__name__)
            heard.unreadable = str(error)
        else:
            heard.unreadable = ""
