"""Playback of bags: the recorded messages are published again, in their original timing."""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from itertools import islice, takewhile
from typing import Final

import anyio
import anyio.to_thread
from anyio.abc import ObjectSendStream

from seoro.bridges.ros2.clock import CLOCK_QOS, SECOND, TOPIC, TYPE
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.recording.errors import unwrapped
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic
from seoro.bridges.ros2.recording.reader import Bag
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import Durability, History, Qos, Reliability
from seoro.concurrency.background import background
from seoro.errors import UsageError

MAX_BATCH: Final = 200  # messages of a batch
MAX_BATCH_SIZE: Final = 4 * 1024 * 1024  # [bytes] of a batch
AHEAD: Final = 4  # number of batches that are read ahead
MATCHING_TIMEOUT: Final = 2.0  # [s] for the connection to present subscriptions


@dataclass(frozen=True)
class Playback:
    """Options of playing a bag.

    Attributes:
        topics: Full names of the topics to play; all if empty.
        rate: Speed factor.
        start_offset: Time to skip at the start [s].
        clock_rate: Rate at which to publish the time of the bag on `/clock` [Hz]; None for never.
    """

    topics: tuple[str, ...] = ()
    rate: float = 1.0
    start_offset: float = 0.0
    clock_rate: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("playback rate", self.rate), ("clock rate", self.clock_rate)):
            if value is not None and not (0 < value < math.inf):
                raise UsageError(f"invalid {name} {value:g}: expected a number above 0")
        if not 0 <= self.start_offset < math.inf:
            raise UsageError(f"invalid start offset {self.start_offset:g} s: expected 0 s or more")


async def play(
    node: RosNode, bag: Bag, playback: Playback = Playback(), *, on_note: Callable[[str], None] = lambda text: None
) -> Mapping[str, int]:
    """Play a bag to its end.

    Present subscriptions get all messages. Messages that are late, since the disk or the machine is slow, are
    published at once. Transient local messages before the start offset are published nonetheless, such as maps and
    static frames.

    Args:
        node: Publishing node.
        bag: Bag to play.
        playback: Options.
        on_note: Called with notes.

    Returns:
        Number of published messages by topic.

    Raises:
        UnknownTopic: The bag lacks a topic.
        UnreadableBag: The bag is damaged.
        UsageError: The bag is shorter than the offset.
        UnknownInterface: Neither the bag nor seoro has the definition of a type.
        WrongType, DefinitionMismatch: The subscriptions have another type, or another definition of it.
    """
    topics = bag.choose(playback.topics)
    duration = (bag.extent.end - bag.extent.start) / SECOND
    if playback.start_offset > duration:
        raise UsageError(
            f"the start offset {playback.start_offset:g} s is after the end of {bag.path} ({duration:.3f} s)"
        )
    if playback.clock_rate is not None and TOPIC in {topic.name for topic in topics}:
        topics = tuple(topic for topic in topics if topic.name != TOPIC)
        on_note(f"{TOPIC} of the bag is not played, since its time is published")
    begin = bag.extent.start + round(playback.start_offset * SECOND)
    published: Counter[str] = Counter({topic.name: 0 for topic in topics})
    with unwrapped():
        async with _publishing(node, topics) as publications, _reading(bag, list(publications), begin) as batches:
            if playback.start_offset:
                for message in await anyio.to_thread.run_sync(_latched_messages, bag, topics, begin):
                    publications[message.topic].send(message.payload)
                    published[message.topic] += 1
            pace = _Pace(begin, playback.rate)
            async with _clock(node, pace, playback.clock_rate):
                async for batch in batches:
                    for message in batch:
                        await pace.wait_for(message.received)
                        publications[message.topic].send(message.payload)
                        published[message.topic] += 1
    return published


class _Pace:
    """Clock of the time in the bag, which starts when it is made.

    Args:
        begin: First time in the bag [ns since the epoch].
        rate: Speed factor.
    """

    def __init__(self, begin: int, rate: float) -> None:
        self._begin = begin
        self._rate = rate
        self._started = time.monotonic()

    @property
    def now(self) -> int:
        """Present time in the bag [ns since the epoch]."""
        return self._begin + round((time.monotonic() - self._started) * self._rate * SECOND)

    async def wait_for(self, moment: int) -> None:
        """Wait for a time in the bag [ns since the epoch]."""
        left = (moment - self._begin) / SECOND / self._rate - (time.monotonic() - self._started)
        await anyio.sleep(max(left, 0))


@asynccontextmanager
async def _publishing(node: RosNode, topics: Sequence[BagTopic]) -> AsyncIterator[dict[str, Publication]]:
    """Create the publishers of topics, and wait until present subscriptions have found them."""
    async with AsyncExitStack() as stack:
        publications = {
            topic.name: await stack.enter_async_context(
                node.publishing(topic.name, topic.type, _offer(topic.qos), type_hash=topic.type_hash or None)
            )
            for topic in topics
        }
        with anyio.move_on_after(MATCHING_TIMEOUT):
            for name, publication in publications.items():
                if node.graph.subscriptions(name):
                    await publication.wait_for_subscription()
        yield publications


@asynccontextmanager
async def _reading(bag: Bag, topics: list[str], begin: int) -> AsyncIterator[AsyncIterator[list[BagMessage]]]:
    """Read batches of messages ahead in a thread."""
    send, receive = anyio.create_memory_object_stream[list[BagMessage]](AHEAD)
    async with background() as tasks, receive:
        tasks.start_soon(_read, bag.messages(topics, begin), send)
        yield receive


async def _read(messages: Iterator[BagMessage], send: ObjectSendStream[list[BagMessage]]) -> None:
    async with send:
        while batch := await anyio.to_thread.run_sync(_batch, messages):
            await send.send(batch)


def _latched_messages(bag: Bag, topics: Sequence[BagTopic], begin: int) -> list[BagMessage]:
    """Return the messages that publishers kept for late subscriptions at a time, in the order of the bag."""
    kept: dict[str, deque[BagMessage]] = {}
    for topic in topics:
        depths = [qos.depth for qos in topic.qos if qos.is_transient_local]
        if depths:
            kept[topic.name] = deque(maxlen=sum(depths))
    if kept:
        for message in takewhile(lambda message: message.received < begin, bag.messages(kept)):
            kept[message.topic].append(message)
    return sorted((message for each in kept.values() for message in each), key=lambda message: message.received)


def _batch(messages: Iterator[BagMessage]) -> list[BagMessage]:
    batch, size = [], 0
    for message in islice(messages, MAX_BATCH):
        batch.append(message)
        size += len(message.payload)
        if size > MAX_BATCH_SIZE:
            break
    return batch


@asynccontextmanager
async def _clock(node: RosNode, pace: _Pace, rate: float | None) -> AsyncIterator[None]:
    """Publish the time of the bag at a rate; do nothing without a rate."""
    if rate is None:
        yield
        return
    async with node.publishing(TOPIC, TYPE, CLOCK_QOS) as publication, background() as tasks:

        def publish() -> None:
            seconds, nanoseconds = divmod(pace.now, SECOND)
            publication.publish({"clock": {"sec": seconds, "nanosec": nanoseconds}})

        async def tick() -> None:
            while True:
                await anyio.sleep(1 / rate)
                publish()

        publish()
        tasks.start_soon(tick)
        yield
        publish()


def _offer(recorded: Sequence[Qos]) -> Qos:
    """Return a QoS profile that is compatible with all subscriptions of the recorded publishers.

    The publisher keeps as many messages for late subscriptions as all recorded publishers together.
    """
    if not recorded:
        return Qos()
    kept = sum(qos.depth for qos in recorded if qos.is_transient_local)
    return Qos(
        Reliability.RELIABLE if any(qos.is_reliable for qos in recorded) else Reliability.BEST_EFFORT,
        Durability.TRANSIENT_LOCAL if any(qos.is_transient_local for qos in recorded) else Durability.VOLATILE,
        History.KEEP_ALL if any(qos.history is History.KEEP_ALL for qos in recorded) else History.KEEP_LAST,
        depth=max(kept, *(qos.depth for qos in recorded)),
    )
