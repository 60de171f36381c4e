"""Subscriptions, publishers and frames of a ROS 2 system for actions; see `contracts.ros2` for the methods."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import NamedTuple

from seoro.bridges.ros2.clients.members import ReceivedMessage
from seoro.bridges.ros2.descriptions import decode_message
from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import Message, UnknownInterface
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Publication, ReceivedPayload, Subscription
from seoro.bridges.ros2.type_matching import check_type


class _UndecodedMessage(NamedTuple):
    """A message whose type definition is being fetched."""

    received: ReceivedPayload
    decoding: asyncio.Future[Message]


class RosSubscription:
    """A subscription that ends with an error when a publisher of another type is found.

    Args:
        subscription: Subscription of the node.
        node: Subscribing node.
    """

    def __init__(self, subscription: Subscription, node: RosNode) -> None:
        self._subscription = subscription
        self._node = node
        self._error: WrongType | None = None
        self._undecoded: _UndecodedMessage | None = None

    def receive_nowait(self) -> ReceivedMessage | None:
        """Return the oldest unread message; None while it is missing, or while its type is being fetched."""
        if self._undecoded is not None:
            return self._take_decoded(self._undecoded)
        received = self._subscription.receive_nowait()
        if received is not None:
            return self._decode(received)
        if self._error is not None:
            raise self._error
        return None

    def _decode(self, received: ReceivedPayload) -> ReceivedMessage | None:
        try:
            return ReceivedMessage(self._subscription.decode(received), received.arrived * 1e-9)
        except (UnknownInterface, DefinitionMismatch):
            decoding = asyncio.ensure_future(decode_message(self._node, self._subscription, received))
            self._undecoded = _UndecodedMessage(received, decoding)
        return None

    def _take_decoded(self, undecoded: _UndecodedMessage) -> ReceivedMessage | None:
        if not undecoded.decoding.done():
            return None
        self._undecoded = None
        return ReceivedMessage(undecoded.decoding.result(), undecoded.received.arrived * 1e-9)

    def on_arrival(self, call: Callable[[], None]) -> None:
        """Call a function once, soon after a message or an error is available."""
        if self._undecoded is not None:
            self._undecoded.decoding.add_done_callback(lambda _: call())
        else:
            self._subscription.on_arrival(call)

    async def close(self) -> None:
        """Fetch no more type definitions."""
        if self._undecoded is not None:
            self._undecoded.decoding.cancel()
            await asyncio.gather(self._undecoded.decoding, return_exceptions=True)

    @property
    def lost(self) -> int:
        """Number of messages dropped from the buffer or lost in transit."""
        return self._subscription.lost + self._subscription.missed

    async def watch_types(self) -> None:
        """Close the subscription when all publishers of its topic have another type."""
        topic, type_name = self._subscription.topic, self._subscription.type
        node = self._node

        def find_mismatch(graph: RosGraph) -> WrongType | None:
            try:
                check_type(topic, type_name, node.others(graph.publishers(topic)))
            except WrongType as error:
                return error
            return None

        self._error = await node.graph.wait_for(find_mismatch)
        self._subscription.close()


class RosPublisher:
    """A publisher of a topic.

    Args:
        publication: Publisher of the node.
        node: Publishing node.
    """

    def __init__(self, publication: Publication, node: RosNode) -> None:
        self._publication = publication
        self._node = node
        self.publish = publication.publish

    async def wait_for_subscription(self, timeout: float) -> bool:
        """Wait until messages reach the subscriptions; return False at once without subscriptions."""
        if not self._node.graph.subscriptions(self._publication.topic):
            return False
        try:
            await self._publication.wait_for_subscription(timeout)
        except TimeoutError:
            return False
        return True
