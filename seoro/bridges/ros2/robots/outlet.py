"""What a robot is told on a topic: a publisher that is there as soon as those on the topic mean the same by it.

A robot that goes and comes back may have the topic with another type, which is published from then on.
"""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable

from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.topics import Publication
from seoro.changes import Changes

log = logging.getLogger(__name__)


class Outlet:
    """A publisher of a topic of the robot.

    Args:
        link: To the robot.
        topic: Its name.
        choose: Gives the type to publish; None while there is nobody to publish to.
        note: Told why nothing can be published, once for each reason.

    Attributes:
        topic: Full name.
        publication: The publisher; None while there is none.
        problem: Why there is none, if others on the topic are in the way.
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
        self._close: Callable[[], Awaitable[None]] = _nothing
        self._changes = Changes()

    async def run(self) -> None:
        """Publish as soon as that is possible, by the type that is wanted; runs as long as the bridge."""
        graph, noted = self._link.node.graph, ""
        while True:
            type_name = await graph.wait_for(self._other_type)
            assert type_name is not None, "it is waited for"
            self.publication = None
            await self._close()
            try:
                self.publication, self._close = await self._link.publish(self.topic, type_name)
            except (WrongType, DefinitionMismatch) as error:
                self.problem = str(error)
                if noted != self.problem:
                    self._note(self.problem)
                noted = self.problem
                await self._wait_for_others(graph)
            self.problem = ""
            self._changes.tell()

    def _other_type(self, graph: RosGraph) -> str | None:
        """The type to publish, if it is not published already."""
        chosen = self._choose(graph)
        return None if self.publication is not None and self.publication.type == chosen else chosen

    async def wait(self) -> Publication:
        """Wait for the publisher."""
        publication = await self._changes.wait_for(lambda: self.publication)
        assert publication is not None, "it is waited for"
        return publication

    async def _wait_for_others(self, graph: RosGraph) -> None:
        """Wait until it is not the same any more who publishes the topic, and who subscribes to it."""

        def there() -> tuple[object, ...]:
            return graph.publishers(self.topic), graph.subscriptions(self.topic)

        before = there()
        await graph.wait_for(lambda _: there() != before)


async def _nothing() -> None:
    """Close nothing."""
