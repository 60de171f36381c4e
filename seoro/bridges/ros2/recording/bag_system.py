"""A recorded bag as a ROS 2 system that a run observes: messages arrive at their times in the bag.

The bag is the clock of the run. Nothing can be sent into the past, so that the system has neither publishers nor
services.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, contextmanager
from typing import Any, Final

from seoro.bridges.ros2.clients.members import ReceivedMessage
from seoro.bridges.ros2.errors import WrongType
from seoro.bridges.ros2.interfaces import InvalidPayload, TypeStore
from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import BagMessage
from seoro.bridges.ros2.recording.reader import Bag
from seoro.bridges.ros2.tf import TransformBuffer
from seoro.bridges.ros2.tf.poses import FramePoses
from seoro.bridges.ros2.wire import Durability
from seoro.concurrency.condition import Condition
from seoro.errors import BackendLost
from seoro.runtime.contracts import ros2 as contract
from seoro.runtime.contracts.backends import EXHAUSTED, WARNING, EventHandler, LossHandler

ROBOT: Final = "robot"  # base type of all robots
TURNS: Final = 5  # of the event loop, for tasks that wait for frames
TRANSFORMS: Final = "tf2_msgs/msg/TFMessage"
_SECOND: Final = 1_000_000_000  # [ns]


class BagSubscription:
    """A subscription to a topic of the bag; see `contracts.ros2.RosSubscription`.

    Args:
        type_name: Type of the messages.
        types: Definitions of the type, as in the bag.
    """

    lost = 0

    def __init__(self, type_name: str, types: TypeStore) -> None:
        self._type = type_name
        self._types = types
        self._unread: deque[BagMessage] = deque()
        self._calls: list[Callable[[], None]] = []

    def receive_nowait(self) -> ReceivedMessage | None:
        """Return the oldest unread message, or None."""
        if not self._unread:
            return None
        message = self._unread.popleft()
        return ReceivedMessage(self._types.decode(self._type, message.payload), message.received / _SECOND)

    def on_arrival(self, call: Callable[[], None]) -> None:
        """Call a function once a message is available."""
        if self._unread:
            call()
        else:
            self._calls.append(call)

    def put(self, message: BagMessage) -> None:
        """Add a message."""
        self._unread.append(message)
        calls, self._calls = self._calls, []
        for call in calls:
            call()


class BagFrames(FramePoses):
    """Frames of the bag.

    Args:
        topics: Topics of transforms, in the namespace of the frames.
    """

    def __init__(self, topics: Sequence[str]) -> None:
        self.topics = tuple(topics)
        self._changes = Condition()
        super().__init__(TransformBuffer(), self._changes.wait_for)

    def put(self, topic: str, message: Any) -> None:
        """Add the transforms of a message."""
        self.buffer.put_message(message, is_static=topic.endswith("tf_static"))
        self._changes.notify_all()


class BagClock:
    """The time of arrival in the bag; see `contracts.ros2.RosClock`."""

    jumps = 0

    def at(self, arrived: float) -> float:
        """Return the time of arrival, which the recorder has noted."""
        return arrived

    async def wait_until(self, moment: float) -> None:
        """Return at once: no observing action waits for a time of the clock."""


class BagSystem:
    """A bag as a backend and time server of a run; see `contracts.ros2.ObservedSystem`.

    Args:
        bag: The bag.
        namespaces: Namespaces of the recorded robots of a lab, by their names there. None if the bag was recorded
            on any robot of the scenario.
    """

    def __init__(self, bag: Bag, namespaces: Mapping[str, str] | None = None) -> None:
        self.name = f"the bag {bag.path}"
        self.topics = frozenset(bag.topics)
        self._bag = bag
        self._namespaces = namespaces
        self._types = TypeStore.bundled()
        self._start = self._now = bag.extent.start
        self._subscriptions: dict[str, list[BagSubscription]] = {}
        self._frames: list[BagFrames] = []
        self._wanted: frozenset[str] = frozenset()
        self._coming: Iterator[BagMessage] = iter(())
        self._next: BagMessage | None = None
        self._on_event: EventHandler = lambda _name, _arguments: None
        self._has_begun = False

    # ------------------------------------------------------------ backend and time server

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Return the name of an actor if it is a robot: the bag was recorded on it. Labs assign theirs."""
        return actor if self._namespaces is None and ROBOT in types else None

    def reason_unobeyed(self) -> str:
        """See `Observing`."""
        return "a recorded robot obeys no commands: observe it, for example with `tf_close_to`"

    def namespace_of(self, robot: str) -> str:
        """Return the namespace of a robot in a lab file; empty for the root."""
        return (self._namespaces or {}).get(robot, "")

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """See `Backend`."""
        self._on_event = on_event

    async def end_run(self) -> None:
        """Do nothing: nothing was started."""

    def loss_since(self, moment: float) -> str:
        """Return an empty text: a bag is never lost."""
        return ""

    async def advance(self, until: float) -> float:
        """Deliver the next messages, if their time is at most `until` [s since the start of the bag].

        After the end of the bag, the run is notified that it has ended.
        """
        limit = self._start + round(until * _SECOND)
        message = self._peek()
        end = self._bag.extent.end
        if message is None or message.received > limit:
            self._now = max(self._now, limit)
            self._has_begun = self._now > self._start
            if limit > end:
                seconds = (end - self._start) / _SECOND
                reason = f"{self.name} ends after {seconds:.3f} s, and the scenario still waits"
                self._on_event(EXHAUSTED, {"time": until, "reason": reason})
            return until
        self._now, self._has_begun = message.received, True
        while message is not None and message.received == self._now:
            self._deliver(message)
            self._next = next(self._coming, None)
            message = self._next
        if self._frames:
            for _ in range(TURNS):
                await asyncio.sleep(0)
        return (self._now - self._start) / _SECOND

    def _peek(self) -> BagMessage | None:
        """Return the next message of an observed topic."""
        wanted = frozenset(self._subscriptions) | {topic for each in self._frames for topic in each.topics}
        if wanted != self._wanted:
            self._wanted = wanted
            first = self._now + 1 if self._has_begun else self._start
            self._coming = self._read(wanted, first)
            self._next = next(self._coming, None)
        return self._next

    def _read(self, topics: frozenset[str], first: int) -> Iterator[BagMessage]:
        """Yield messages of topics.

        Raises:
            BackendLost: A file of the bag is damaged.
        """
        try:
            yield from self._bag.messages(topics, first) if topics else ()
        except UnreadableBag as error:
            raise BackendLost(str(error)) from error

    def _deliver(self, message: BagMessage) -> None:
        for subscription in self._subscriptions.get(message.topic, ()):
            subscription.put(message)
        frames = [each for each in self._frames if message.topic in each.topics]
        for each in frames:
            self._add_transforms(each, message)

    def _add_transforms(self, frames: BagFrames, message: BagMessage) -> None:
        try:
            frames.put(message.topic, self._definitions(message.topic).decode(TRANSFORMS, message.payload))
        except InvalidPayload as error:
            self._on_event(WARNING, {"message": f"{message.topic}: {error}"})

    # ------------------------------------------------------------ topics

    @asynccontextmanager
    async def subscribing(self, topic: str, type_name: str, qos: str) -> AsyncIterator[BagSubscription]:
        """Observe a topic during the block; latched topics begin with their last message."""
        name = _full(topic)
        [described] = self._bag.choose([name])
        canonical = self._types.canonical(type_name)
        if described.type != canonical:
            raise WrongType(f"{name} is of type {described.type} in the bag, not {canonical}")
        subscription = BagSubscription(canonical, self._definitions(name))
        if any(each.durability is Durability.TRANSIENT_LOCAL for each in described.qos):
            for message in deque(self._past([name]), maxlen=1):
                subscription.put(message)
        with self._observed(name, subscription):
            yield subscription

    @contextmanager
    def _observed(self, name: str, subscription: BagSubscription) -> Iterator[None]:
        self._subscriptions.setdefault(name, []).append(subscription)
        try:
            yield
        finally:
            self._subscriptions[name].remove(subscription)
            if not self._subscriptions[name]:
                del self._subscriptions[name]

    def _past(self, topics: Sequence[str]) -> Iterator[BagMessage]:
        """Yield the messages that were delivered before."""
        for message in self._bag.messages(topics):
            if message.received > self._now or not self._has_begun:
                return
            yield message

    def _definitions(self, topic: str) -> TypeStore:
        """Return the definitions that the recorded robot had."""
        described = self._bag.topics[topic]
        edition = self._types.matching(described.type, described.type_hash) if described.type_hash else None
        return edition or self._types

    @asynccontextmanager
    async def clock(self, note: contract.Note) -> AsyncIterator[BagClock]:
        """Use the clock of the bag."""
        yield BagClock()

    @asynccontextmanager
    async def frames(self, namespace: str, note: contract.Note) -> AsyncIterator[BagFrames]:
        """Follow the frames recorded in a namespace, with those of the past."""
        prefix = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
        topics = [name for name in (f"{prefix}/tf", f"{prefix}/tf_static") if name in self._bag.topics]
        self._bag.choose(topics[:1] or [f"{prefix}/tf"])
        frames = BagFrames(topics)
        for message in self._past(topics):
            self._add_transforms(frames, message)
        self._frames.append(frames)
        try:
            yield frames
        finally:
            self._frames.remove(frames)


def _full(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"
