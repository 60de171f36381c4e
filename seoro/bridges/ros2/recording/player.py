"""Playing bags: what was recorded is published again, at the times at which it was received."""

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

from seoro.background import background
from seoro.bridges.ros2.clock import CLOCK_QOS, SECOND, TOPIC, TYPE
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bridges.ros2.recording.reader import Bag
from seoro.bridges.ros2.recording.sources import BagMessage
from seoro.bridges.ros2.recording.unwrapping import unwrapped
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import Durability, History, Qos, Reliability
from seoro.errors import InvalidUse

AT_ONCE: Final = 200  # messages that are read together at most
ENOUGH: Final = 4 * 1024 * 1024  # [bytes] after which no others are read with them
AHEAD: Final = 4  # times as many are read ahead
MATCHING_TIMEOUT: Final = 2.0  # [s] that those who subscribe already may take to be reached


@dataclass(frozen=True)
class Playback:
    """How a bag is played.

    Attributes:
        topics: Full names of those that are played; all if there is none.
        rate: Seconds of the bag in a second.
        start_offset: [s] from the beginning of the bag that are left out.
        clock_rate: [Hz] at which the time of the bag is published on `/clock`; not at all when None.
    """

    topics: tuple[str, ...] = ()
    rate: float = 1.0
    start_offset: float = 0.0
    clock_rate: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("rate", self.rate), ("rate of the clock", self.clock_rate)):
            if value is not None and not (0 < value < math.inf):
                raise InvalidUse(f"the {name} of a bag that is played is positive, not {value:g}")
        if not 0 <= self.start_offset < math.inf:
            raise InvalidUse(f"the offset from which a bag is played is 0 s or more, not {self.start_offset:g} s")


async def play(
    node: RosNode, bag: Bag, playback: Playback = Playback(), *, on_note: Callable[[str], None] = lambda text: None
) -> Mapping[str, int]:
    """Play a bag to its end.

    Whoever subscribes before gets everything; messages that are late, since the disk or the machine is slow, are
    published at once. Of what is left out at the beginning, messages that their publishers kept for those who come
    later are published nonetheless, such as maps and static frames.

    Args:
        node: Publishes.
        bag: What is played.
        playback: How.
        on_note: Is told what happens, in words for people.

    Returns:
        Messages that were published, by topic.

    Raises:
        UnknownTopic: The bag does not have a topic.
        UnreadableBag: The bag is damaged.
        InvalidUse: It is shorter than the offset.
        UnknownInterface: Neither the bag nor seoro knows the definition of a type.
        WrongType, DefinitionMismatch: Those who subscribe mean something else.
    """
    topics = bag.choose(playback.topics)
    duration = (bag.extent.end - bag.extent.start) / SECOND
    if playback.start_offset > duration:
        raise InvalidUse(
            f"{bag.path} lasts {duration:.3f} s; it cannot be played from {playback.start_offset:g} s"
        )
    if playback.clock_rate is not None and TOPIC in {topic.name for topic in topics}:
        topics = tuple(topic for topic in topics if topic.name != TOPIC)
        on_note(f"{TOPIC} of the bag is not played, since the clock is published")
    begin = bag.extent.start + round(playback.start_offset * SECOND)
    published: Counter[str] = Counter({topic.name: 0 for topic in topics})
    with unwrapped():
        async with _publishing(node, topics) as publications, _reading(bag, list(publications), begin) as batches:
            if playback.start_offset:
                for message in await anyio.to_thread.run_sync(_kept, bag, topics, begin):
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
    """When it is what time in the bag. Starts when it is made.

    Args:
        begin: [ns] since the epoch, in the bag.
        rate: Seconds of the bag in a second.
    """

    def __init__(self, begin: int, rate: float) -> None:
        self._begin = begin
        self._rate = rate
        self._started = time.monotonic()

    @property
    def now(self) -> int:
        """[ns] since the epoch, in the bag."""
        return self._begin + round((time.monotonic() - self._started) * self._rate * SECOND)

    async def wait_for(self, moment: int) -> None:
        """Wait until it is that time in the bag [ns since the epoch]."""
        left = (moment - self._begin) / SECOND / self._rate - (time.monotonic() - self._started)
        await anyio.sleep(max(left, 0))


@asynccontextmanager
async def _publishing(node: RosNode, topics: Sequence[BagTopic]) -> AsyncIterator[dict[str, Publication]]:
    """Publishers of topics, which have been found by those who subscribe already."""
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
    """Batches of messages, read ahead by a thread."""
    send, receive = anyio.create_memory_object_stream[list[BagMessage]](AHEAD)
    async with background() as tasks, receive:
        tasks.start_soon(_read, bag.messages(topics, begin), send)
        yield receive


async def _read(messages: Iterator[BagMessage], send: ObjectSendStream[list[BagMessage]]) -> None:
    async with send:
        while batch := await anyio.to_thread.run_sync(_batch, messages):
            await send.send(batch)


def _kept(bag: Bag, topics: Sequence[BagTopic], begin: int) -> list[BagMessage]:
    """What publishers still kept at some time for those who come later, in the order of the bag."""
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
    for message in islice(messages, AT_ONCE):
        batch.append(message)
        size += len(message.payload)
        if size > ENOUGH:
            break
    return batch


@asynccontextmanager
async def _clock(node: RosNode, pace: _Pace, rate: float | None) -> AsyncIterator[None]:
    """Publish the time of the bag; not at all when the rate is None."""
    if rate is None:
        yield
        return
    async with node.publishing(TOPIC, TYPE, CLOCK_QOS) as publication, background() as tasks:

        def tell() -> None:
            seconds, nanoseconds = divmod(pace.now, SECOND)
            publication.publish({"clock": {"sec": seconds, "nanosec": nanoseconds}})

        async def tick() -> None:
            while True:
                await anyio.sleep(1 / rate)
                tell()

        tell()
        tasks.start_soon(tick)
        yield
        tell()


def _offer(recorded: Sequence[Qos]) -> Qos:
    """What satisfies all who were satisfied by the publishers that were recorded.

    What each of them kept for those who come later is kept by one.
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
