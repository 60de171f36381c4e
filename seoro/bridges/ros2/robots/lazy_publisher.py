"""Publisher to a robot that starts when the subscriptions and their type are known.

After a restart, the robot may have the topic with another type, which is published from then on.
"""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable

from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.topics import Publication
from seoro.concurrency.condition import Condition

log = logging.getLogger(__name__)


class LazyPublisher:
    """Publisher of a topic of a robot.

    Args:
        link: Link to the robot.
        topic: Name of the topic.
        choose: Returns the type to publish; None without subscriptions.
        note: Called with each conflict of types, once in a row.

    Attributes:
        topic: Full name of the topic.
        publication: Publisher; None while it is missing.
        problem: Conflict of types on the topic; empty without one.
    """

    def __init__(
        self,
        link: Link,
        topic: str,
        choose: Callable[[RosGraph], str | None],
        note: Callable[[str], None] = log.warning,
    ) -> None:
        self.topic = link.node.resolve(topic)
        self.publication: Publication | None = None
        self.problem = ""
        self._link = link
        self._choose = choose
        self._note = note
        self._close: Callable[[], Awaitable[None]] | None = None
        self._changes = Condition()

    async def run(self) -> None:
        """Create the publisher when its type is known, and again for another type, without end."""
        graph, noted = self._link.node.graph, ""
        while True:
            type_name = await graph.wait_for(self._other_type)
            assert type_name is not None, "the condition is true"
            self.publication = None
            if self._close is not None:
                await self._close()
            try:
                self.publication, self._close = await self._link.publish(self.topic, type_name)
            except (WrongType, DefinitionMismatch) as error:
                self.problem = str(error)
                if noted != self.problem:
                    self._note(self.problem)
                noted = self.problem
                await self._wait_for_change(graph)
            self.problem = ""
            self._changes.notify_all()

    def _other_type(self, graph: RosGraph) -> str | None:
        """Return the type to publish; None if it is published already."""
        chosen = self._choose(graph)
        return None if self.publication is not None and self.publication.type == chosen else chosen

    async def wait(self) -> Publication:
        """Wait for the publisher."""
        publication = await self._changes.wait_for(lambda: self.publication)
        assert publication is not None, "the condition is true"
        return publication

    async def _wait_for_change(self, graph: RosGraph) -> None:
        """Wait until the publishers or the subscriptions of the topic change."""

        def endpoints() -> tuple[object, ...]:
            return graph.publishers(self.topic), graph.subscriptions(self.topic)

        before = endpoints()
        await graph.wait_for(lambda _: endpoints() != before)
