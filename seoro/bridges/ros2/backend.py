"""A ROS 2 system as a backend of runs, for the actions of `osc.ros`; see `Ros2System` for the methods."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import anyio.to_thread
from anyio.abc import TaskGroup

from seoro.bridges.ros2.clients.cancellation import cancel_goal
from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.clients.lifecycle import watching_lifecycle
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.clients.parameters import set_parameter
from seoro.bridges.ros2.clients.presence import Presence, full_name
from seoro.bridges.ros2.clock import SharedClock
from seoro.bridges.ros2.descriptions import decode_message, node_for_service
from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import Message, UnknownInterface
from seoro.bridges.ros2.participant import RosNode, RosOptions, connect_system
from seoro.bridges.ros2.recording import Playback, Recording, check_storage, open_bag, play, record
from seoro.bridges.ros2.tf import Stamped, TransformBuffer, TransformError
from seoro.bridges.ros2.tf.listener import TransformListener, listen
from seoro.bridges.ros2.topics import Publication, ReceivedPayload, Subscription
from seoro.bridges.ros2.type_matching import check_type
from seoro.bridges.ros2.wire import PRESETS
from seoro.bridges.session import Outages
from seoro.concurrency.background import background
from seoro.runtime.contracts import ros2 as contract
from seoro.runtime.contracts.backends import EventHandler, LossHandler

ROBOT = "robot"  # base type of all robots


@dataclass(slots=True)
class ReceivedMessage:
    """A received message.

    Args:
        message: The decoded message.
        arrived: Time of arrival [s since the epoch].
    """

    message: Any
    arrived: float

    @property
    def members(self) -> Members:
        """Members of the message."""
        return Members(self.message)


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


class Frames:
    """Frames of a system.

    Args:
        listener: Listener to their transforms.
    """

    def __init__(self, listener: TransformListener) -> None:
        self._listener = listener
        self._last: dict[tuple[str, str], Stamped] = {}

    async def next_pose(self, frame: str, parent: str) -> contract.FramePose:
        """Wait for a pose of a frame in another one that differs from the last returned pose."""
        last = self._last.get((frame, parent))

        def changed(buffer: TransformBuffer) -> Stamped | None:
            found = buffer.find(frame, parent)
            return found if found != last else None

        found = await self._listener.wait_for(changed)
        assert found is not None, "the condition is true"
        self._last[frame, parent] = found
        stamp = None if found.stamp is None else found.stamp * 1e-9
        return contract.FramePose(found.transform.translation, found.transform.rotation, stamp)

    def describe_absence(self, frame: str, parent: str) -> str:
        """Return why the pose of a frame is unknown; empty if it is known."""
        try:
            self._listener.buffer.lookup(frame, parent)
        except TransformError as error:
            return str(error)
        return ""


class RosBackend:
    """A ROS 2 system, accessed by a node of seoro.

    Args:
        node: Node of seoro.
        name: Name of the system in messages.
        tasks: Task group of subscriptions shared by actions, and of the cancellation of lost goals.
        outages: Outages of the connection to the system.
    """

    def __init__(self, node: RosNode, name: str, tasks: TaskGroup, outages: Outages) -> None:
        self._node = node
        self.name = name
        self._outages = outages
        self._presence = Presence(node)
        self._clock = SharedClock(node, tasks)
        self._tasks = tasks

    def loss_since(self, moment: float) -> str:
        """See `Connected`. Messages sent during an outage are lost, so each outage counts."""
        if self._node.system.session.is_cut_off:
            return "the connection to the ROS 2 system is lost"
        if self._outages.since(moment):
            return "the connection to the ROS 2 system was lost meanwhile, and messages may be missing"
        return ""

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Return the name of an actor if it is a robot: robots without another backend are in this system."""
        return actor if ROBOT in types else None

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """Do nothing: the system reports no events by itself, and waiting actions notice outages."""

    async def end_run(self) -> None:
        """Do nothing: actions end everything that they started."""

    @asynccontextmanager
    async def publishing(self, topic: str, type_name: str, qos: str) -> AsyncIterator[RosPublisher]:
        """Create a publisher of a topic."""
        async with self._node.publishing(topic, type_name, PRESETS[qos]) as publication:
            yield RosPublisher(publication, self._node)

    @asynccontextmanager
    async def subscribing(self, topic: str, type_name: str, qos: str) -> AsyncIterator[RosSubscription]:
        """Create a subscription to a topic."""
        async with self._node.subscribing(topic, type_name, PRESETS[qos]) as subscription, background() as tasks:
            incoming = RosSubscription(subscription, self._node)
            tasks.start_soon(incoming.watch_types)
            try:
                yield incoming
            finally:
                await incoming.close()

    async def wait_for(self, wanted: Sequence[contract.Wanted]) -> None:
        """Wait until all wanted entities exist at the same time."""
        presence = self._presence
        resolved = [presence.resolved(each) for each in wanted]
        await self._node.graph.wait_for(lambda graph: all(presence.has(graph, each) for each in resolved))

    def missing(self, wanted: Sequence[contract.Wanted]) -> tuple[str, ...]:
        """Describe the wanted entities that do not exist now."""
        presence = self._presence
        resolved = [presence.resolved(each) for each in wanted]
        return tuple(presence.missing(each) for each in resolved if not presence.has(self._node.graph, each))

    async def call(self, service: str, type_name: str, request: contract.Members) -> Members:
        """Call a service once it has a server, and return its response."""
        node = await node_for_service(self._node, service, type_name)
        types = node.system.types
        types.encode(f"{types.canonical(type_name)}_Request", request)  # raises errors before any wait
        async with node.calling(service, type_name) as client:
            await client.wait_for_server()
            return Members(await client.call(request))

    def sending_goal(
        self,
        action: str,
        type_name: str,
        goal: contract.Members,
        feedback: Callable[[contract.Members], None],
        note: contract.Note,
        *,
        late: bool,
    ) -> AbstractAsyncContextManager[contract.RosGoal]:
        """Send a goal to an action; the goal is canceled at the end of the block."""

        def cancel_lost(unsettled: Goal) -> None:
            if unsettled.is_lost:
                self._tasks.start_soon(cancel_goal, self._node, unsettled.action, unsettled.goal_id, note)

        return sending_goal(self._node, action, type_name, goal, feedback, note, cancel_lost, late=late)

    async def set_parameter(self, node: str, name: str, text: str) -> None:
        """Set a parameter of a node."""
        await set_parameter(self._node, full_name(node), name, text)

    def lifecycle(self, node: str) -> AbstractAsyncContextManager[AsyncIterator[str]]:
        """Follow the states of a node."""
        return watching_lifecycle(self._node, full_name(node))

    def clock(self, note: contract.Note) -> AbstractAsyncContextManager[SharedClock]:
        """Follow the time of the system."""
        return self._clock.using(note)

    @asynccontextmanager
    async def frames(self, namespace: str, note: contract.Note) -> AsyncIterator[Frames]:
        """Follow the frames published in a namespace."""
        async with (
            listen(self._node, namespace, on_note=note) as listener,
            self._clock.using(note, listener.buffer.clear),
        ):
            yield Frames(listener)

    @asynccontextmanager
    async def recording(
        self,
        folder: Path,
        topics: Sequence[str],
        note: contract.Note,
        *,
        storage: str,
        hidden: bool,
        use_sim_time: bool,
    ) -> AsyncIterator[Recording]:
        """Record topics into a bag."""
        check_storage(storage)
        pattern = "" if topics else ".*"
        recording = record(
            self._node, folder, topics, pattern=pattern, hidden=hidden, use_sim_time=use_sim_time, on_note=note
        )
        async with recording as made:
            yield made
        note(_summary(made))

    async def play(
        self,
        bag: Path,
        topics: Sequence[str],
        note: contract.Note,
        *,
        start_offset: float,
        clock_rate: float | None,
    ) -> None:
        """Play a bag to its end."""
        names = tuple(self._node.resolve(topic) for topic in topics)
        playback = Playback(names, start_offset=start_offset, clock_rate=clock_rate)
        await play(self._node, await anyio.to_thread.run_sync(open_bag, bag), playback, on_note=note)


def _summary(recording: Recording) -> str:
    """Summarise a recording: messages by topic, and lost messages."""
    counts = ", ".join(f"{count} of {topic}" for topic, count in recording.counts.items()) or "no messages"
    lost = sum(recording.lost.values()) + sum(recording.missed.values())
    return f"recorded {counts} in {recording.folder}{f'; {lost} messages were lost' if lost else ''}"


@asynccontextmanager
async def open_backend(options: RosOptions) -> AsyncIterator[RosBackend]:
    """Join a ROS 2 system for the duration of the block; see `connect_system` for the errors."""
    async with (
        connect_system(options) as system,
        system.node(f"seoro_{system.session.identity[:6]}") as node,
        background() as tasks,
    ):
        await anyio.to_thread.run_sync(system.prepare)
        outages = await anyio.to_thread.run_sync(system.session.blocking.outages)
        yield RosBackend(node, f"the ROS 2 system at {options.endpoint}", tasks, outages)
