"""A recorded bag as a ROS 2 system that a run observes: messages arrive at their times in the bag.

Nothing can be sent into the past, so that the system has neither publishers nor services. The times are those of
`bag_time.py`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, contextmanager
from typing import Final

from seoro.bridges.ros2.errors import WrongType
from seoro.bridges.ros2.interfaces import InvalidPayload, TypeStore, UnknownInterface
from seoro.bridges.ros2.recording.bag_clock import SECOND, BagClock
from seoro.bridges.ros2.recording.bag_streams import BagFrames, BagSubscription, lifecycle_states
from seoro.bridges.ros2.recording.bag_tracks import BagTracks
from seoro.bridges.ros2.recording.bag_types import recorded_types
from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import BagMessage
from seoro.bridges.ros2.recording.reader import Bag
from seoro.bridges.ros2.wire import Durability
from seoro.concurrency.condition import Condition
from seoro.errors import BackendLost
from seoro.runtime.contracts import ros2 as contract
from seoro.runtime.contracts.backends import EXHAUSTED, WARNING, EventHandler, LossHandler
from seoro.runtime.contracts.tracks import TrackReporter

ROBOT: Final = "robot"  # base type of all robots
TRANSFORMS: Final = "tf2_msgs/msg/TFMessage"
GOALS: Final = "/_action/status"  # end of topics with the states of goals
TRANSITION: Final = "lifecycle_msgs/msg/TransitionEvent"


class BagSystem:
    """A bag as a backend of a run; see `contracts.ros2.ObservedSystem`.

    Args:
        bag: The bag.
        robots: Names of the topics of the recorded robots of a lab, by their names there. None if the bag was
            recorded on any robot of the scenario.
        is_alone: Whether a run cannot go on after the end of the bag, since the bag is its clock.

    Attributes:
        changed: Notified when an action begins to observe.
    """

    def __init__(
        self, bag: Bag, robots: Mapping[str, contract.RobotNames] | None = None, *, is_alone: bool = True
    ) -> None:
        self.name = f"the bag {bag.path}"
        self.topics = frozenset(bag.topics)
        self._bag = bag
        self._robots = robots
        self._types = TypeStore.bundled()
        self._definitions_of: dict[str, TypeStore] = {}  # by topic
        self._start = bag.extent.start
        self.changed = Condition()
        self._clock = BagClock(self._start, self.changed.notify_all)
        self._is_alone = is_alone
        self._is_exhausted = False
        self._subscriptions: dict[str, list[BagSubscription]] = {}
        self._frames: list[BagFrames] = []
        self._wanted: frozenset[str] = frozenset()
        self._coming: Iterator[BagMessage] = iter(())
        self._next: BagMessage | None = None
        self._on_event: EventHandler = lambda _name, _arguments: None
        self._has_begun = False
        self._actors: list[str] = []  # robots of the scenario, in a bag without a lab
        self._tracks: BagTracks | None = None

    # ------------------------------------------------------------ backend and time

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Return the name of an actor if it is a robot: the bag was recorded on it. Labs assign theirs."""
        if self._robots is not None or ROBOT not in types:
            return None
        self._actors.append(actor)
        return actor

    def reason_unobeyed(self) -> str:
        """See `Observing`."""
        hint = "a recorded robot obeys no commands: observe it, for example with `tf_close_to`"
        if goals := sorted(topic for topic in self.topics if topic.endswith(GOALS)):
            hint += f", or check how its own goals ended, with `check_data` on {', '.join(goals)}"
        return hint

    def names_of(self, robot: str) -> contract.RobotNames:
        """Return the names of the topics of a robot, by the lab file."""
        return (self._robots or {}).get(robot, contract.RobotNames())

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """See `Backend`."""
        self._on_event = on_event

    async def start_tracks(self, rate: float, report: TrackReporter, scans: float = 0.0) -> None:
        """See `Tracks`. Without a lab, the poses are those of the only robot of the scenario."""
        robots = self._robots
        if robots is None:
            robots = dict.fromkeys(self._actors, contract.RobotNames()) if len(self._actors) == 1 else {}
        self._tracks = BagTracks(self._bag, robots, self._definitions, rate, report)

    async def end_run(self) -> None:
        """Do nothing: nothing was started."""

    def loss_since(self, moment: float) -> str:
        """Return an empty text: a bag is never lost."""
        return ""

    @property
    def time(self) -> float:
        """Present time [s since the start of the bag]."""
        return self._seconds(self._clock.time)

    @property
    def duration(self) -> float:
        """Time from the first to the last message of the bag [s]."""
        return self._seconds(self._bag.extent.end)

    def _seconds(self, at: int) -> float:
        """Convert a time [ns since the epoch] into seconds since the start of the bag."""
        return (at - self._start) / SECOND

    def next_time(self) -> float | None:
        """Return the next time of a message or an awaited one [s since the start of the bag]; None without.

        An action that still observes the bag at its end waits for that, too.

        Raises:
            BackendLost: A file of the bag is damaged.
        """
        message, moment, now = self._peek(), self._clock.next_moment, self._clock.time
        times = [] if message is None else [message.received]
        times += [] if moment is None or moment <= now else [moment]
        if self._is_observed and not times and not self._is_exhausted:
            times = [max(now, self._bag.extent.end + 1)]
        return self._seconds(min(times)) if times else None

    def deliver(self, until: float) -> None:
        """Deliver all messages up to a time [s since the start of the bag], which becomes the present time.

        After the end of the bag, the run is notified, if it cannot go on or an action still observes the bag.

        Raises:
            BackendLost: A file of the bag is damaged.
        """
        limit = self._start + round(until * SECOND)
        if self._tracks is not None:
            with self._damages():
                self._tracks.advance(limit)
        while (message := self._peek()) is not None and message.received <= limit:
            self._clock.set(message.received)
            self._has_begun = True
            self._deliver(message)
            self._next = next(self._coming, None)
        self._clock.set(max(self._clock.time, limit))
        self._has_begun = self._has_begun or self._clock.time > self._start
        if limit > self._bag.extent.end and (self._is_alone or self._is_observed) and not self._is_exhausted:
            self._is_exhausted = True
            self._on_event(EXHAUSTED, {"time": until, "reason": self._end()})

    @property
    def _is_observed(self) -> bool:
        """Whether an action observes the bag."""
        return bool(self._subscriptions or self._frames)

    async def settle(self, has_report: Callable[[], bool]) -> None:
        """See `BagClock.settle`."""
        await self._clock.settle(has_report)

    def _end(self) -> str:
        """Describe the end of the bag."""
        who = "the scenario still waits" if self._is_alone else "an action still observes it"
        return f"{self.name} ends after {self.duration:.3f} s, and {who}"

    def _peek(self) -> BagMessage | None:
        """Return the next message of an observed topic."""
        wanted = frozenset(self._subscriptions) | {topic for each in self._frames for topic in each.topics}
        if wanted != self._wanted:
            self._wanted = wanted
            first = self._clock.time + 1 if self._has_begun else self._start
            self._coming = self._read(wanted, first)
            self._next = next(self._coming, None)
        return self._next

    def _read(self, topics: frozenset[str], first: int) -> Iterator[BagMessage]:
        """Yield messages of topics.

        Raises:
            BackendLost: A file of the bag is damaged.
        """
        with self._damages():
            yield from self._bag.messages(topics, first) if topics else ()

    @contextmanager
    def _damages(self) -> Iterator[None]:
        """Convert errors of a damaged file, which are those of a lost backend."""
        try:
            yield
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
        try:
            canonical = self._types.canonical(type_name) if type_name else described.type
        except UnknownInterface:
            canonical = self._definitions(name).canonical(type_name)
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
        self.changed.notify_all()
        try:
            yield
        finally:
            self._subscriptions[name].remove(subscription)
            if not self._subscriptions[name]:
                del self._subscriptions[name]

    def _past(self, topics: Sequence[str]) -> Iterator[BagMessage]:
        """Yield the messages that were delivered before."""
        for message in self._bag.messages(topics):
            if message.received > self._clock.time or not self._has_begun:
                return
            yield message

    def _definitions(self, topic: str) -> TypeStore:
        """Return the definitions that the recorded robot had.

        Raises:
            InvalidDefinition, UnknownInterface: They are invalid, or missing.
        """
        if topic not in self._definitions_of:
            described = self._bag.topics[topic]
            self._definitions_of[topic] = recorded_types(described, self._types, f"the bag {self._bag.path}")
        return self._definitions_of[topic]

    @asynccontextmanager
    async def clock(self, note: contract.Note) -> AsyncIterator[BagClock]:
        """Use the clock of the bag."""
        with self._clock.followed():
            yield self._clock

    def machine_clock(self) -> BagClock:
        """Return the clock of the bag: the recording machine has noted its time."""
        return self._clock

    @asynccontextmanager
    async def lifecycle(self, node: str) -> AsyncIterator[AsyncIterator[str]]:
        """Follow the states of a lifecycle node, by its recorded transitions.

        Before the first one, the node is in the state in which that one starts.
        """
        topic = f"{_full(node)}/transition_event"
        async with self.subscribing(topic, TRANSITION, "") as transitions:
            types = self._definitions(topic)
            messages = (types.decode(TRANSITION, each.payload) for each in self._bag.messages([topic]))
            first = next(messages, None)
            past = [types.decode(TRANSITION, each.payload) for each in self._past([topic])]
            with self._clock.followed():
                yield lifecycle_states(transitions, first, past)

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
        self.changed.notify_all()
        try:
            with self._clock.followed():
                yield frames
        finally:
            self._frames.remove(frames)


def _full(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"
