"""Recorder of topics of a ROS 2 system.

A topic is recorded once it has a publisher, whose QoS profile and definition are written into the bag. Later
changes are reported and noted in the bag: lost publishers, lost messages and clock jumps.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import TaskGroup, TaskStatus

from seoro.bridges.ros2.clock import CLOCK_QOS, TOPIC, TYPE, Note, SimClock
from seoro.bridges.ros2.descriptions import fetch_types
from seoro.bridges.ros2.errors import WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import TypeStore, UnknownInterface
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.recording.errors import RefusedRecording, unwrapped
from seoro.bridges.ros2.recording.mcap_file import Compression
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bridges.ros2.recording.writer import BagWriter, write_bag
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Endpoint, Qos, is_hidden
from seoro.bridges.ros2.wire.qos import matching_qos
from seoro.bridges.session import Bound
from seoro.concurrency.background import background
from seoro.errors import UsageError

WAITING: Final = Bound(10_000, 64 * 1024 * 1024)  # queue of a topic, before the queue of the writer


@dataclass(frozen=True)
class Wanted:
    """Topics to be recorded.

    Attributes:
        names: Full names of required topics.
        pattern: Pattern of the full names of other topics.
        hidden: Whether the pattern includes hidden topics.
    """

    names: tuple[str, ...]
    pattern: re.Pattern[str] | None = None
    hidden: bool = False

    def of(self, graph: RosGraph) -> tuple[str, ...]:
        """Return the required topics, and the present topics that match the pattern."""
        if self.pattern is None:
            return self.names
        matching = (name for name in graph.topics(hidden=self.hidden) if self.pattern.fullmatch(name))
        return tuple(dict.fromkeys((*self.names, *matching)))


class Recording:
    """A recording in progress. Made by `record`.

    Attributes:
        folder: Folder of the bag.
    """

    def __init__(
        self, node: RosNode, wanted: Wanted, writer: BagWriter, on_note: Note, *, use_sim_time: bool
    ) -> None:
        self.folder = writer.folder
        self._node = node
        self._wanted = wanted
        self._writer = writer
        self._clock = SimClock(self.note) if use_sim_time else None
        self._on_note = on_note
        self._subscriptions: dict[str, Subscription] = {}
        self._publishers: dict[str, tuple[Endpoint, ...]] = {}
        self._counts: Counter[str] = Counter()
        self._refused: set[str] = set()
        self._noted: set[object] = set()  # keys of notes that are made once
        self._notes: list[str] = []
        self._complete = anyio.Event()
        self._following = anyio.CancelScope()
        self._finished: dict[str, anyio.Event] = {}  # set when all received messages of a topic are written

    @property
    def missing(self) -> tuple[str, ...]:
        """Missing topics: required ones, and `/clock` if its time is used."""
        clock = (TOPIC,) if self._clock is not None and not self._clock.has_started else ()
        return tuple(
            dict.fromkeys((*clock, *(name for name in self._wanted.names if name not in self._subscriptions)))
        )

    @property
    def topics(self) -> tuple[str, ...]:
        """Recorded topics, in the order of discovery."""
        return tuple(self._subscriptions)

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of recorded messages by topic."""
        return dict(self._counts)

    @property
    def lost(self) -> Mapping[str, int]:
        """Number of received messages that were dropped, by topic."""
        return self._writer.lost

    @property
    def missed(self) -> Mapping[str, int]:
        """Number of messages lost in transit, by topic, as far as senders number them."""
        return {name: each.missed for name, each in self._subscriptions.items() if each.missed}

    async def wait_complete(self) -> None:
        """Wait until all required topics are recorded; `missing` lists the missing ones."""
        await self._complete.wait()

    def note(self, text: str) -> None:
        """Report a note, and write it into the bag."""
        self._notes.append(text)
        self._writer.note("notes", "\n".join(self._notes))
        self._on_note(text)

    def _note_once(self, key: object, text: str) -> None:
        if key not in self._noted:
            self._noted.add(key)
            self.note(text)

    async def follow(self, tasks: TaskGroup) -> None:
        """Record the wanted topics when they appear, in tasks of a group.

        Raises:
            WrongType: The publishers of a topic have different types.
        """
        with self._following:
            if self._clock is not None:
                tasks.start_soon(self._follow_clock, self._clock)
                await self._clock.wait_started()
            while True:
                if not self.missing:
                    self._complete.set()
                for name, publishers in (await self._node.graph.wait_for(self._changes)).items():
                    before = self._publishers.get(name, ())
                    self._publishers[name] = publishers
                    if name in self._subscriptions:
                        self._note_change(name, before, publishers)
                    elif publishers and name not in self._refused:
                        await self._begin(tasks, name, publishers)

    async def end(self) -> None:
        """Receive no more messages, and write the received ones."""
        self._following.cancel()
        for subscription in self._subscriptions.values():
            subscription.close()
        for finished in self._finished.values():
            await finished.wait()
        if self.missed:
            self._writer.note("missed", ", ".join(f"{count} of {name}" for name, count in self.missed.items()))

    async def _follow_clock(self, clock: SimClock) -> None:
        async with self._node.subscribing(TOPIC, TYPE, CLOCK_QOS) as subscription:
            await clock.follow(subscription)

    def _changes(self, graph: RosGraph) -> dict[str, tuple[Endpoint, ...]]:
        """Return the topics whose publishers have changed."""
        now = {name: graph.publishers(name) for name in self._wanted.of(graph)}
        now |= {name: graph.publishers(name) for name in self._subscriptions}
        return {name: found for name, found in now.items() if found != self._publishers.get(name, ())}

    async def _begin(self, tasks: TaskGroup, name: str, publishers: tuple[Endpoint, ...]) -> None:
        types = sorted({publisher.type for publisher in publishers})
        try:
            if len(types) > 1:
                raise WrongType(f"{name} has several types: {', '.join(types)}")
            await tasks.start(self._record, name, publishers)
        except UsageError as error:
            if name in self._wanted.names:
                raise
            self._refused.add(name)
            self.note(f"{name} is not recorded: {error}")

    async def _record(
        self, name: str, publishers: tuple[Endpoint, ...], *, task_status: TaskStatus[None] = TASK_STATUS_IGNORED
    ) -> None:
        topic, definition = await self._describe(name, publishers)
        async with self._node.subscribing(
            name, topic.type, matching_qos(topic.qos), WAITING, is_decoded=False
        ) as subscription:
            self._writer.add_topic(topic, definition)
            self._subscriptions[name] = subscription
            self._finished[name] = anyio.Event()
            task_status.started()
            try:
                await self._write_messages(topic, subscription)
            finally:
                self._finished[name].set()

    async def _write_messages(self, topic: BagTopic, subscription: Subscription) -> None:
        name, lost = topic.name, 0
        async for received in subscription:
            if subscription.lost > lost:
                self._writer.count_lost(name, subscription.lost - lost)
                lost = subscription.lost
                self._note_loss(name)
            if subscription.first_missed is not None:
                first = subscription.first_missed
                self._note_once(("missed", name), f"{name}: messages are lost in transit, first number {first}")
            if received.type_hash and topic.type_hash and received.type_hash != topic.type_hash:
                self._note_once(
                    (name, received.type_hash),
                    f"{name}: messages with another definition of {topic.type} are not recorded"
                    f" ({received.type_hash}; recorded: {topic.type_hash})",
                )
                continue
            time, sent = received.arrived, received.sent
            if self._clock is not None:
                time = sent = self._clock.now
            if self._writer.write(name, received.payload, time, sent, received.sequence or 0):
                self._counts[name] += 1
            else:
                self._note_loss(name)

    def _note_loss(self, name: str) -> None:
        self._note_once(
            ("lost", name), f"{name}: messages are dropped, since they arrive faster than the disk writes"
        )

    async def _describe(self, name: str, publishers: Sequence[Endpoint]) -> tuple[BagTopic, str]:
        """Return the description of a topic in the bag, and the definition of its type, if known."""
        type_name = publishers[0].type
        qos = tuple(publisher.qos or Qos() for publisher in publishers)
        theirs = sorted({publisher.type_hash for publisher in publishers if publisher.type_hash})
        known, problem = _known(self._node.system.types, type_name, theirs)
        for each in theirs if known is None else ():
            known = known or await fetch_types(self._node, publishers, type_name, each)
        if known is None:
            self.note(f"{name} is recorded without the definition of {type_name}{problem}")
            return BagTopic(name, type_name, theirs[0] if theirs else "", qos), ""
        return BagTopic(name, type_name, known.type_hash(type_name), qos), known.schema(type_name)

    def _note_change(self, name: str, before: Sequence[Endpoint], now: Sequence[Endpoint]) -> None:
        if not now:
            nodes = sorted({publisher.node.full_name for publisher in before if publisher.node is not None})
            of = f", {' and '.join(nodes)}" if nodes else ""
            self.note(f"{name} has lost its publisher{of}")
        elif not before:
            self.note(f"{name} has a publisher again")
        recorded = self._subscriptions[name].type
        others = sorted({publisher.type for publisher in now} - {recorded})
        if others:
            self.note(f"{name}: messages of type {', '.join(others)} are not recorded (recorded type: {recorded})")


@asynccontextmanager
async def record(
    node: RosNode,
    folder: Path,
    topics: Sequence[str] = (),
    *,
    pattern: str = "",
    hidden: bool = False,
    use_sim_time: bool = False,
    storage: str = "",
    compression: Compression = "none",
    on_note: Note = lambda text: None,
) -> AsyncIterator[Recording]:
    """Record topics during the block.

    Args:
        node: Subscribing node.
        folder: Folder of the bag, which must not exist.
        topics: Names of required topics (`Recording.wait_complete`).
        pattern: Regular expression; topics whose full names match are recorded when they appear.
        hidden: Whether to record hidden topics (a part of the name begins with `_`).
        use_sim_time: Whether to stamp messages with `/clock` instead of the time of this machine.
        storage: Storage format, by its rosbag2 name; empty for MCAP.
        compression: Compression of the messages in an MCAP file.
        on_note: Called with notes.

    Raises:
        RefusedRecording, InvalidName: The recording request is invalid.
        RecordingFailed: Not everything could be written.
    """
    wanted = _wanted(node, topics, pattern, hidden)
    with unwrapped():
        async with write_bag(folder, storage=storage, compression=compression) as writer, background() as tasks:
            recording = Recording(node, wanted, writer, on_note, use_sim_time=use_sim_time)
            tasks.start_soon(writer.wait_failed)
            tasks.start_soon(recording.follow, tasks)
            try:
                yield recording
            finally:
                with anyio.CancelScope(shield=True):
                    await recording.end()


def _wanted(node: RosNode, topics: Sequence[str], pattern: str, hidden: bool) -> Wanted:
    if not topics and not pattern:
        raise RefusedRecording("no topics to record", help="name topics, or give the pattern '.*' for all")
    names = tuple(dict.fromkeys(node.resolve(topic) for topic in topics))
    for name in names:
        if is_hidden(name) and not hidden:
            raise RefusedRecording(f"{name} is a hidden topic, and hidden topics are not included")
    try:
        return Wanted(names, re.compile(pattern) if pattern else None, hidden)
    except re.error as error:
        raise RefusedRecording(f"the pattern {pattern!r} is an invalid regular expression: {error}") from None


def _known(types: TypeStore, type_name: str, theirs: Sequence[str]) -> tuple[TypeStore | None, str]:
    """Return the definitions that match one of some hashes; otherwise None, and the reason."""
    try:
        ours = types.type_hash(type_name)
        editions = [types.matching(type_name, each) for each in theirs or (ours,)]
    except UnknownInterface:
        return None, ", which seoro does not know"
    known = next((edition for edition in editions if edition is not None), None)
    return known, f": the definitions of the robot ({', '.join(theirs)}) and of seoro ({ours}) differ"
