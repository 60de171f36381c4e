"""A ROS 2 system as a backend of runs: what actions of `osc.ros` ask; see `Ros2System` for what the methods do."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import anyio.to_thread
from anyio.abc import TaskGroup

from seoro.background import background
from seoro.bridges.ros2.agreement import check_type
from seoro.bridges.ros2.clients.goals import Doubt, pursuing
from seoro.bridges.ros2.clients.lifecycle import following_lifecycle
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.clients.parameters import set_parameter
from seoro.bridges.ros2.clients.presence import Presence, full_name
from seoro.bridges.ros2.clients.recall import recall
from seoro.bridges.ros2.clock import SharedClock
from seoro.bridges.ros2.descriptions import decoded, knowing_service
from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.interfaces import Message, TypeStore, UnknownInterface
from seoro.bridges.ros2.participant import RosNode, RosSystem, connect
from seoro.bridges.ros2.recording import Playback, Recording, check_storage, open_bag, play, record
from seoro.bridges.ros2.tf import Stamped, TransformBuffer, TransformError
from seoro.bridges.ros2.tf.listener import TransformListener, listen
from seoro.bridges.ros2.topics import Publication, Received, Subscription
from seoro.bridges.ros2.wire import PRESETS, named_dialect
from seoro.bridges.session import Outages
from seoro.runtime import ros_system as contract
from seoro.runtime.contracts import Happened, Lost

ROBOT = "robot"  # what all types of robots inherit


class Arrived:
    """A message that has arrived.

    Args:
        message: The message.
        arrived: When [s since the epoch].
    """

    __slots__ = ("arrived", "message")

    def __init__(self, message: Message, arrived: float) -> None:
        self.message: Any = message
        self.arrived = arrived

    @property
    def members(self) -> Members:
        """What it says."""
        return Members(self.message)


class _Unread(NamedTuple):
    """A message that cannot be read before somebody has told the definition of its type."""

    received: Received
    asking: asyncio.Future[Message]


class Incoming:
    """A subscription that ends with an error when a publisher of another type is found.

    Args:
        subscription: The subscription.
        node: Whose it is.
    """

    def __init__(self, subscription: Subscription, node: RosNode) -> None:
        self._subscription = subscription
        self._node = node
        self._error: WrongType | None = None
        self._unread: _Unread | None = None

    def take_now(self) -> Arrived | None:
        """The oldest message that nobody has taken, if there is one, and its definition is known."""
        if self._unread is not None:
            return self._read_at_last(self._unread)
        received = self._subscription.take_now()
        if received is not None:
            return self._read(received)
        if self._error is not None:
            raise self._error
        return None

    def _read(self, received: Received) -> Arrived | None:
        try:
            return Arrived(self._subscription.decode(received), received.arrived * 1e-9)
        except (UnknownInterface, DefinitionMismatch):
            asking = asyncio.ensure_future(decoded(self._node, self._subscription, received))
            self._unread = _Unread(received, asking)
        return None

    def _read_at_last(self, unread: _Unread) -> Arrived | None:
        if not unread.asking.done():
            return None
        self._unread = None
        return Arrived(unread.asking.result(), unread.received.arrived * 1e-9)

    def when_arrived(self, call: Callable[[], None]) -> None:
        """Have something called once, soon after there is a message, or something to be raised."""
        if self._unread is not None:
            self._unread.asking.add_done_callback(lambda _: call())
        else:
            self._subscription.when_arrived(call)

    async def close(self) -> None:
        """Ask no more."""
        if self._unread is not None:
            self._unread.asking.cancel()
            await asyncio.gather(self._unread.asking, return_exceptions=True)

    @property
    def lost(self) -> int:
        """Messages that arrived and were not taken in time, or got lost on their way."""
        return self._subscription.lost + self._subscription.missed

    async def watch_types(self) -> None:
        """End when there are publishers, and all of them are of another type."""
        topic, type_name = self._subscription.topic, self._subscription.type
        node, own = self._node, self._node.node.session

        def mistaken(graph: Any) -> WrongType | None:
            try:
                check_type(topic, type_name, [each for each in graph.publishers(topic) if each.session != own])
            except WrongType as error:
                return error
            return None

        self._error = await node.graph.wait_for(mistaken)
        self._subscription.close()


class Outgoing:
    """A publisher.

    Args:
        publication: The publication.
        node: Whose it is.
    """

    def __init__(self, publication: Publication, node: RosNode) -> None:
        self._publication = publication
        self._node = node
        self.publish = publication.publish

    async def wait_for_subscription(self, timeout: float) -> bool:
        """Wait until what is published reaches those who have subscribed."""
        if not self._node.graph.subscriptions(self._publication.topic):
            return False
        try:
            await self._publication.wait_for_subscription(timeout)
        except TimeoutError:
            return False
        return True


class Frames:
    """Frames that are followed.

    Args:
        listener: Follows them.
    """

    def __init__(self, listener: TransformListener) -> None:
        self._listener = listener
        self._last: dict[tuple[str, str], Stamped] = {}

    async def next_pose(self, frame: str, parent: str) -> contract.FramePose:
        """The latest pose of a frame in another one."""
        last = self._last.get((frame, parent))

        def changed(buffer: TransformBuffer) -> Stamped | None:
            found = buffer.find(frame, parent)
            return found if found != last else None

        found = await self._listener.wait_for(changed)
        assert found is not None, "that is what was waited for"
        self._last[frame, parent] = found
        stamp = None if found.stamp is None else found.stamp * 1e-9
        return contract.FramePose(found.transform.translation, found.transform.rotation, stamp)

    def absence(self, frame: str, parent: str) -> str:
        """Why it is not known where a frame is."""
        try:
            self._listener.buffer.lookup(frame, parent)
        except TransformError as error:
            return str(error)
        return ""


class RosBackend:
    """A ROS 2 system that is reached by a node of its own.

    Args:
        node: The node.
        name: How messages call the system.
        tasks: Where goals are canceled that were lost sight of, and what actions share is followed.
        outages: The outages of the connection to the system.
    """

    def __init__(self, node: RosNode, name: str, tasks: TaskGroup, outages: Outages) -> None:
        self._node = node
        self._name = name
        self._outages = outages
        self._presence = Presence(node)
        self._clock = SharedClock(node, tasks)
        self._tasks = tasks

    @property
    def name(self) -> str:
        """How messages call it."""
        return self._name

    def loss_since(self, moment: float) -> str:
        """See `Connected`. What the system sent during an outage is missed, so each outage counts."""
        if self._node.system.session.is_cut_off:
            return "the connection to the ROS 2 system is lost"
        if self._outages.since(moment):
            return "the connection to the ROS 2 system was lost meanwhile, and messages may be missed"
        return ""

    def home_of(self, actor: str, types: Sequence[str]) -> str | None:
        """Robots that have found no other home live here."""
        return actor if ROBOT in types else None

    async def start_run(self, happened: Happened, lost: Lost) -> None:
        """Nothing happens here unasked; and what is lost may come back, which waiting actions notice."""

    async def end_run(self) -> None:
        """Nothing is left to end: what actions began, they have ended."""

    def publishing(self, topic: str, type_name: str, qos: str) -> AbstractAsyncContextManager[Outgoing]:
        """Be a publisher of a topic."""
        return self._publishing(topic, type_name, qos)

    @asynccontextmanager
    async def _publishing(self, topic: str, type_name: str, qos: str) -> AsyncIterator[Outgoing]:
        async with self._node.publishing(topic, type_name, PRESETS[qos]) as publication:
            yield Outgoing(publication, self._node)

    @asynccontextmanager
    async def subscribing(self, topic: str, type_name: str, qos: str) -> AsyncIterator[Incoming]:
        """Be a subscription of a topic."""
        async with self._node.subscribing(topic, type_name, PRESETS[qos]) as subscription, background() as tasks:
            incoming = Incoming(subscription, self._node)
            tasks.start_soon(incoming.watch_types)
            try:
                yield incoming
            finally:
                await incoming.close()

    async def wait_for(self, wanted: Sequence[contract.Wanted]) -> None:
        """Wait until all of some things are there at one time."""
        presence = self._presence
        resolved = [presence.resolved(each) for each in wanted]
        await self._node.graph.wait_for(lambda graph: all(presence.has(graph, each) for each in resolved))

    def missing(self, wanted: Sequence[contract.Wanted]) -> tuple[str, ...]:
        """Which of them are not there now."""
        presence = self._presence
        resolved = [presence.resolved(each) for each in wanted]
        return tuple(presence.missing(each) for each in resolved if not presence.has(self._node.graph, each))

    async def call(self, service: str, type_name: str, request: contract.Members) -> Members:
        """Call a service, once there is a server of it, and wait for its response."""
        node = await knowing_service(self._node, service, type_name)
        types = node.system.types
        types.encode(f"{types.canonical(type_name)}_Request", request)  # what is wrong is reported at once
        async with node.calling(service, type_name) as client:
            await client.wait_for_server()
            return Members(await client.call(request))

    def pursuing(
        self,
        action: str,
        type_name: str,
        goal: contract.Members,
        feedback: Callable[[contract.Members], None],
        note: contract.Note,
        *,
        late: bool,
    ) -> AbstractAsyncContextManager[contract.RosGoal]:
        """Send a goal to an action; at the end of the block it is canceled."""

        def call_off(doubt: Doubt) -> None:
            if doubt.is_lost:
                self._tasks.start_soon(recall, self._node, doubt.action, doubt.number, note)

        return pursuing(self._node, action, type_name, goal, feedback, note, call_off, late=late)

    async def set_parameter(self, node: str, name: str, text: str) -> None:
        """Set a parameter of a node."""
        await set_parameter(self._node, full_name(node), name, text)

    def lifecycle(self, node: str) -> AbstractAsyncContextManager[AsyncIterator[str]]:
        """Follow the states of a node."""
        return following_lifecycle(self._node, full_name(node))

    def clock(self, note: contract.Note) -> AbstractAsyncContextManager[SharedClock]:
        """Follow the time of the system."""
        return self._clock.used(note)

    @asynccontextmanager
    async def frames(self, namespace: str, note: contract.Note) -> AsyncIterator[Frames]:
        """Follow the frames whose transforms are published in a namespace."""
        async with (
            listen(self._node, namespace, on_note=note) as listener,
            self._clock.used(note, listener.buffer.clear),
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
    """What has been recorded, and what not."""
    counts = ", ".join(f"{count} of {topic}" for topic, count in recording.counts.items()) or "no messages"
    lost = sum(recording.lost.values()) + sum(recording.missed.values())
    return f"recorded {counts} in {recording.folder}{f'; {lost} messages were lost' if lost else ''}"


@dataclass(frozen=True)
class RosOptions:
    """How a run reaches a ROS 2 system.

    Args:
        endpoint: Zenoh endpoint of the router that the robot's nodes use, or of the bridge.
        domain: ROS_DOMAIN_ID.
        dialect: `rmw_zenoh` or `ros2dds`; found out when None.
        interfaces: Folders with definitions of interfaces, in whose place seoro's own are not taken.
    """

    endpoint: str
    domain: int = 0
    dialect: str | None = None
    interfaces: Sequence[Path] = ()


def _load_types(folders: Sequence[Path]) -> TypeStore:
    """The definitions, with what encodes: that takes long to load, and would hold up a run in its middle."""
    types = TypeStore.bundled()
    for folder in folders:
        types = types.add_folder(folder)
    types.encode("std_msgs/msg/Empty", {})
    return types


@asynccontextmanager
async def reach(options: RosOptions) -> AsyncIterator[RosSystem]:
    """Reach a ROS 2 system for as long as the block lasts.

    Raises:
        InvalidUse: The definitions cannot be read, or there is no such dialect.
        BackendError: Nobody listens at the endpoint, or no ROS 2 system is seen there.
    """
    types = await anyio.to_thread.run_sync(_load_types, options.interfaces)
    dialect = named_dialect(options.dialect, options.domain)
    async with connect(options.endpoint, types=types, dialect=dialect, domain=options.domain) as system:
        yield system


@asynccontextmanager
async def open_backend(options: RosOptions) -> AsyncIterator[RosBackend]:
    """Take part in a ROS 2 system for as long as the block lasts; see `reach` for what this raises."""
    async with (
        reach(options) as system,
        system.node(f"seoro_{system.session.identity[:6]}") as node,
        background() as tasks,
    ):
        outages = await anyio.to_thread.run_sync(system.session.blocking.outages)
        yield RosBackend(node, f"the ROS 2 system at {options.endpoint}", tasks, outages)
