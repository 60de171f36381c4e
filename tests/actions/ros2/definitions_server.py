"""Servers of ROS 2 made from the published definitions of a distribution, where genuine ones are not available.

They record goals and requests, and send the answers of a test.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import anyio

from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.interfaces import Message, TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import RmwZenoh


@dataclass(frozen=True)
class Offer:
    """An action or a service.

    Args:
        name: Full name.
        type: Full name of its type.
        answer: Members of the result or of the response.
        status: Final status of goals.
    """

    name: str
    type: str
    answer: Mapping[str, Any] = field(default_factory=dict)
    status: Status = Status.SUCCEEDED


@dataclass
class Servers:
    """Running servers.

    Args:
        node: Their node.

    Attributes:
        seen: Names with goals and requests, in the order of arrival, as plain values.
    """

    node: RosNode
    seen: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    arrival: anyio.Event = field(default_factory=anyio.Event)

    async def execute(self, offer: Offer, goal: GoalHandle) -> GoalEnd:
        self._note(offer, goal.goal)
        return GoalEnd(offer.status, offer.answer)

    async def respond(self, offer: Offer, request: Message) -> Mapping[str, Any]:
        self._note(offer, request)
        return offer.answer

    def _note(self, offer: Offer, message: Message) -> None:
        self.seen.append((offer.name, dict(Members(message))))
        self.arrival.set()

    def of(self, name: str) -> dict[str, Any]:
        """Return the only goal or request of a name."""
        [found] = [members for each, members in self.seen if each == name]
        return found


@asynccontextmanager
async def serving(router: str, types: TypeStore, offers: Sequence[Offer]) -> AsyncIterator[Servers]:
    """Serve actions and services by definitions during the block."""
    async with AsyncExitStack() as stack:
        system = await stack.enter_async_context(connect(router, types=types, dialect=RmwZenoh()))
        node = await stack.enter_async_context(system.node("by_definitions"))
        servers = Servers(node)
        for offer in offers:
            server: Any
            if "/action/" in offer.type:
                server = serving_action(node, offer.name, offer.type, partial(servers.execute, offer))
            else:
                server = node.serving(offer.name, offer.type, partial(servers.respond, offer))
            await stack.enter_async_context(server)
        yield servers
