"""Recording topics of a ROS 2 system.

Topics are recorded from when they have a publisher, whose QoS and definition go into the bag. What happens to them
meanwhile is told and noted in the bag: a publisher that goes, messages that get lost, a clock that jumps.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import TaskGroup, TaskStatus

from seoro.background import background
from seoro.bridges.ros2.clock import CLOCK_QOS, TOPIC, TYPE, SimClock
from seoro.bridges.ros2.descriptions import told_types
from seoro.bridges.ros2.errors import WrongType
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import TypeStore, UnknownInterface
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.recording.errors import RefusedRecording
from seoro.bridges.ros2.recording.mcap_file import Compression
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bridges.ros2.recording.unwrapping import unwrapped
from seoro.bridges.ros2.recording.writer import BagWriter, write_bag
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Endpoint, Qos, Reliability, is_hidden
from seoro.bridges.session import Bound
from seoro.errors import InvalidUse

Note = Callable[[str], None]

WAITING: Final = Bound(10_000, 64 * 1024 * 1024)  # of a topic, until they get to the writer, which has its own


@dataclass(frozen=True)
class Wanted:
    """What is to be recorded.

    Attributes:
        names: Full names of topics that have to be there.
        pattern: Other topics whose full names match, as soon as they are there.
        hidden: Whether the pattern is for hidden topics, too.
    """

    names: tuple[str, ...]
    pattern: re.Pattern[str] | None = None
    hidden: bool = False

    def of(self, graph: RosGraph) -> tuple[str, ...]:
        """The topics that are wanted of those that there are."""
        if self.pattern is None:
            return self.names
        matching = (name for name in graph.topics(hidden=self.hidden) if self.pattern.fullmatch(name))
        return tuple(dict.fromkeys((*self.names, *matching)))


class Recording:
    """A recording that goes on. Made by `record`.

    Attributes:
        folder: The bag.
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
        self._losing: set[str] = set()
        self._missing: set[str] = set()  # topics of which messages do not arrive
        self._others: set[tuple[str, str]] = set()  # topics and definitions by which they are not recorded
        self._notes: list[str] = []
        self._complete = anyio.Event()
        self._following = anyio.CancelScope()
        self._taken: dict[str, anyio.Event] = {}  # set when everything is written that has arrived

    @property
    def missing(self) -> tuple[str, ...]:
        """What is not there of what has to be: topics, and `/clock` if its time is recorded."""
        clock = (TOPIC,) if self._clock is not None and not self._clock.has_started else ()
        return tuple(
            dict.fromkeys((*clock, *(name for name in self._wanted.names if name not in self._subscriptions)))
        )

    @property
    def topics(self) -> tuple[str, ...]:
        """What is recorded, in the order in which it was found."""
        return tuple(self._subscriptions)

    @property
    def counts(self) -> Mapping[str, int]:
        """Messages that have been recorded so far, by topic."""
        return dict(self._counts)

    @property
    def lost(self) -> Mapping[str, int]:
        """Messages that arrived and are not in the bag, by topic."""
        return self._writer.lost

    @property
    def missed(self) -> Mapping[str, int]:
        """Messages that did not even arrive, by topic, as far as their senders number them."""
        return {name: each.missed for name, each in self._subscriptions.items() if each.missed}

    @property
    def notes(self) -> tuple[str, ...]:
        """What has happened, in order."""
        return tuple(self._notes)

    async def wait_complete(self) -> None:
        """Wait until all that has to be there is recorded; `missing` says what is not."""
        await self._complete.wait()

    def note(self, text: str) -> None:
        """Tell, and put into the bag, what has happened."""
        self._notes.append(text)
        self._writer.note("notes", "\n".join(self._notes))
        self._on_note(text)

    async def follow(self, tasks: TaskGroup) -> None:
        """Record what is wanted as soon as it is there, in tasks of a group.

        Raises:
            WrongType: The publishers of a topic do not agree on its type.
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
        """Take nothing in any more, and write what has arrived."""
        self._following.cancel()
        for subscription in self._subscriptions.values():
            subscription.close()
        for taken in self._taken.values():
            await taken.wait()
        if self.missed:
            self._writer.note("missed", ", ".join(f"{count} of {name}" for name, count in self.missed.items()))

    async def _follow_clock(self, clock: SimClock) -> None:
        async with self._node.subscribing(TOPIC, TYPE, CLOCK_QOS) as subscription:
            await clock.follow(subscription)

    def _changes(self, graph: RosGraph) -> dict[str, tuple[Endpoint, ...]]:
        """Topics whose publishers are not those that they were."""
        now = {name: graph.publishers(name) for name in self._wanted.of(graph)}
        now |= {name: graph.publishers(name) for name in self._subscriptions}
        return {name: found for name, found in now.items() if found != self._publishers.get(name, ())}

    async def _begin(self, tasks: TaskGroup, name: str, publishers: tuple[Endpoint, ...]) -> None:
        types = sorted({publisher.type for publisher in publishers})
        try:
            if len(types) > 1:
                raise WrongType(f"{name} has several types, and one is recorded: {', '.join(types)}")
            await tasks.start(self._record, name, publishers)
        except InvalidUse as error:
            if name in self._wanted.names:
                raise
            self._refused.add(name)
            self.note(f"{name} is not recorded: {error}")

    async def _record(
        self, name: str, publishers: tuple[Endpoint, ...], *, task_status: TaskStatus[None] = TASK_STATUS_IGNORED
    ) -> None:
        topic, definition = await self._about(name, publishers)
        async with self._node.subscribing(
            name, topic.type, _request(topic.qos), WAITING, is_decoded=False
        ) as subscription:
            self._writer.add_topic(topic, definition)
            self._subscriptions[name] = subscription
            self._taken[name] = anyio.Event()
            task_status.started()
            try:
                await self._take(topic, subscription)
            finally:
                self._taken[name].set()

    async def _take(self, topic: BagTopic, subscription: Subscription) -> None:
        name, lost = topic.name, 0
        async for received in subscription:
            if subscription.lost > lost:
                self._writer.lose(name, subscription.lost - lost)
                lost = subscription.lost
                self._note_loss(name)
            if name not in self._missing and subscription.first_missed is not None:
                self._missing.add(name)
                self.note(f"{name}: messages do not arrive, the first of them number {subscription.first_missed}")
            if received.type_hash and topic.type_hash and received.type_hash != topic.type_hash:
                self._note_other(topic, received.type_hash)
                continue
            time, sent = received.arrived, received.sent
            if self._clock is not None:
                time = sent = self._clock.now
            if self._writer.write(name, received.payload, time, sent, received.sequence or 0):
                self._counts[name] += 1
            else:
                self._note_loss(name)

    def _note_loss(self, name: str) -> None:
        if name not in self._losing:
            self._losing.add(name)
            self.note(f"{name}: messages are lost, since they come faster than they can be written")

    def _note_other(self, topic: BagTopic, type_hash: str) -> None:
        if (topic.name, type_hash) not in self._others:
            self._others.add((topic.name, type_hash))
            self.note(
                f"{topic.name}: messages by another definition of {topic.type} are not recorded"
                f" ({type_hash}; it is recorded by {topic.type_hash})"
            )

    async def _about(self, name: str, publishers: Sequence[Endpoint]) -> tuple[BagTopic, str]:
        """What the bag says of a topic, and the definition of its type, if that is known."""
        type_name = publishers[0].type
        qos = tuple(publisher.qos or Qos() for publisher in publishers)
        theirs = sorted({publisher.type_hash for publisher in publishers if publisher.type_hash})
        known, problem = _known(self._node.system.types, type_name, theirs)
        for each in theirs if known is None else ():
            known = known or await told_types(self._node, publishers, type_name, each)
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
            self.note(f"{name}: messages of type {', '.join(others)} are not recorded; it was of type {recorded}")


@asynccontextmanager
async def record(
    node: RosNode,
    folder: Path,
    topics: Sequence[str] = (),
    *,
    pattern: str = "",
    hidden: bool = False,
    use_sim_time: bool = False,
    compression: Compression = "none",
    on_note: Note = lambda text: None,
) -> AsyncIterator[Recording]:
    """Record topics for as long as the block lasts.

    Args:
        node: Takes part for the recording.
        folder: The bag, which is made; nothing may be there.
        topics: Names of topics that have to be there (`Recording.wait_complete`).
        pattern: A regular expression; topics whose full names match are recorded as soon as they are there.
        hidden: Whether hidden topics may be recorded: those with a part that begins with `_`.
        use_sim_time: Whether messages get the time of `/clock` instead of that of this machine.
        compression: Of the messages in the file.
        on_note: Is told what happens, in words for people.

    Raises:
        RefusedRecording, InvalidName: What was asked for cannot be recorded.
        RecordingFailed: Not everything could be written.
    """
    wanted = _wanted(node, topics, pattern, hidden)
    with unwrapped():
        async with write_bag(folder, compression=compression) as writer, background() as tasks:
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
        raise RefusedRecording("nothing is to be recorded", help="name topics, or give the pattern '.*' for all")
    names = tuple(dict.fromkeys(node.resolve(topic) for topic in topics))
    for name in names:
        if is_hidden(name) and not hidden:
            raise RefusedRecording(f"{name} is hidden, and hidden topics are not to be recorded")
    try:
        return Wanted(names, re.compile(pattern) if pattern else None, hidden)
    except re.error as error:
        raise RefusedRecording(f"the pattern {pattern!r} is no regular expression: {error}") from None


def _known(types: TypeStore, type_name: str, theirs: Sequence[str]) -> tuple[TypeStore | None, str]:
    """The definitions that agree with one of some hashes; or None, and why there are none, for people."""
    try:
        ours = types.type_hash(type_name)
        editions = [types.matching(type_name, each) for each in theirs or (ours,)]
    except UnknownInterface:
        return None, ", which seoro does not have"
    known = next((edition for edition in editions if edition is not None), None)
    return known, f": that of the robot ({', '.join(theirs)}) is not the one that seoro has ({ours})"


def _request(offered: Sequence[Qos]) -> Qos:
    """What to ask for such that all publishers offer it."""
    reliable = all(qos.is_reliable for qos in offered)
    latched = all(qos.is_transient_local for qos in offered)
    return Qos(
        Reliability.RELIABLE if reliable else Reliability.BEST_EFFORT,
        Durability.TRANSIENT_LOCAL if latched else Durability.VOLATILE,
        depth=max(qos.depth for qos in offered),
    )
