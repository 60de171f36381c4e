"""Messages, frames and lifecycle states of a recorded bag, as actions observe them."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable, Sequence
from typing import Any

from seoro.bridges.ros2.clients.lifecycle import StateTracker, state_name
from seoro.bridges.ros2.clients.members import ReceivedMessage
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.recording.bag_clock import SECOND
from seoro.bridges.ros2.recording.metadata import BagMessage
from seoro.bridges.ros2.tf import TransformBuffer
from seoro.bridges.ros2.tf.poses import FramePoses
from seoro.concurrency.condition import Condition


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
        return ReceivedMessage(self._types.decode(self._type, message.payload), message.received / SECOND)

    def on_arrival(self, call: Callable[[], None]) -> None:
        """Call a function once a message is available."""
        if self._unread:
            call()
        else:
            self._calls.append(call)

    async def receive(self) -> ReceivedMessage:
        """Wait for the next message, and return it."""
        while (message := self.receive_nowait()) is None:
            arrived = asyncio.Event()
            self.on_arrival(arrived.set)
            await arrived.wait()
        return message

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


async def lifecycle_states(
    transitions: BagSubscription, first: Any | None, past: Sequence[Any]
) -> AsyncIterator[str]:
    """Yield the present state of a node, and those after each later transition.

    Args:
        transitions: Its later transitions.
        first: The first recorded transition, which starts at the first state; None without one.
        past: The transitions until now.
    """
    states = deque[str](maxlen=1)
    tracker = StateTracker(states.append)
    if first is not None:
        tracker.set(state_name(first.start_state))
    for transition in past:
        tracker.apply(transition)
    if tracker.is_changing:
        states.clear()
    while True:
        while states:
            yield states.popleft()
        tracker.apply((await transitions.receive()).message)
