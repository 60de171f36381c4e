"""Publishing and subscribing in a ROS 2 system."""

from __future__ import annotations

import itertools
import time
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Any, NamedTuple

import anyio

from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.interfaces import InvalidPayload, Message, TypeStore
from seoro.bridges.ros2.wire import Attachment, Dialect, InvalidAttachment, Qos
from seoro.bridges.session import Bound, Mailbox, Publisher, Sample

ALL = Bound(10_000)  # what a subscription that keeps all messages keeps
MOST_SENDERS = 1024  # of which it is known what has been received


class Publication:
    """A publisher of a topic. Made by `RosNode.publishing`.

    Attributes:
        topic: Full name.
        type: Full name of the type of the messages.
        qos: What it offers.
    """

    def __init__(
        self,
        topic: str,
        type_name: str,
        qos: Qos,
        publisher: Publisher,
        dialect: Dialect,
        gid: bytes,
        types: TypeStore,
        check: Callable[[], object],
    ) -> None:
        self.topic = topic
        self.type = type_name
        self.qos = qos
        self._publisher = publisher
        self._dialect = dialect
        self._gid = gid
        self._types = types
        self._check = check
        self._numbers = itertools.count(1)

    def publish(self, value: Mapping[str, Any] | Message) -> None:
        """Publish a message; missing members have the defaults of the definition. Never waits.

        Raises:
            InvalidValue: It is no message of this type.
            SessionError: The session is closed.
        """
        self.send(self._types.encode(self.type, value))

    async def wait_for_subscription(self, timeout: float | None = None) -> None:
        """Wait until what is published reaches somebody; not where late subscriptions get it anyway.

        Args:
            timeout: [s] of the machine's clock; without end when None.

        Raises:
            WrongType, DefinitionMismatch: Those who have subscribed mean something else.
            TimeoutError: Nobody has subscribed in time.
        """
        try:
            with anyio.fail_after(timeout):
                await self._publisher.wait_for_subscriber()
        except TimeoutError:
            self._check()
            raise

    def send(self, payload: bytes) -> None:
        """Publish a message that is CDR already, with its header."""
        attachment = self._dialect.attachment(next(self._numbers), time.time_ns(), self._gid)
        self._publisher.put(payload, attachment)


class Received(NamedTuple):
    """A message as it came.

    Attributes:
        payload: CDR, with its header.
        arrived: [ns] since the epoch, by the clock of this machine.
        sent: [ns] since the epoch, by the sender's clock; None where senders do not tell.
        sequence: Its number among those of its sender; None where senders do not tell.
        sender: The sender's gid; empty where senders do not tell.
        type_hash: Of the sender's definition of the type; None where that is not told.
    """

    payload: bytes
    arrived: int
    sent: int | None
    sequence: int | None
    sender: bytes
    type_hash: str | None


class Subscription:
    """A subscription of a topic. Made by `RosNode.subscribing`; iterating over it gives what is received.

    Attributes:
        topic: Full name.
        type: Full name of the type of the messages.
    """

    def __init__(self, topic: str, type_name: str, bound: Bound, dialect: Dialect, types: TypeStore) -> None:
        self.topic = topic
        self.type = type_name
        self._waiting: Mailbox[Received] = Mailbox(bound)
        self._missed = 0
        self._first_missed: int | None = None
        self._dialect = dialect
        self._types = types
        self._last: dict[bytes, int] = {}
        self._editions: dict[str, TypeStore] = {}

    @property
    def lost(self) -> int:
        """Messages that arrived and were not taken in time."""
        return self._waiting.lost

    @property
    def missed(self) -> int:
        """Messages that got lost on their way, by the numbers that senders give them; 0 where they give none."""
        return self._missed

    @property
    def first_missed(self) -> int | None:
        """The number that its sender gave to the first message that got lost on its way; None if none has."""
        return self._first_missed

    async def receive(self) -> Received:
        """The next message, as it came; waits for it.

        Raises:
            Closed: There will be none: the subscription has ended.
        """
        return await self._waiting.take()

    async def message(self) -> Message:
        """The next message, decoded; waits for it.

        Raises:
            Closed: There will be none: the subscription has ended.
            InvalidPayload: It is not of this type.
            DefinitionMismatch: Its sender has another definition of the type.
        """
        return self.decode(await self.receive())

    def take_now(self) -> Received | None:
        """The oldest message that waits, as it came, if there is one."""
        return self._waiting.take_now()

    def when_arrived(self, call: Callable[[], None]) -> None:
        """Have something called once, soon after there is a message to take, or there will be none."""
        self._waiting.when_arrived(call)

    def __aiter__(self) -> AsyncIterator[Received]:
        return aiter(self._waiting)

    def decode(self, received: Received) -> Message:
        """What a message says.

        Raises:
            InvalidPayload: It is not of this type.
            DefinitionMismatch: Its sender has another definition of the type.
        """
        types = self._types_of(received.type_hash)
        try:
            return types.decode(self.type, received.payload)
        except InvalidPayload as error:
            raise InvalidPayload(f"a message on {self.topic} cannot be read: {error}") from error

    def _types_of(self, type_hash: str | None) -> TypeStore:
        """The definitions that a sender has; seoro's own if it does not say."""
        if type_hash is None:
            return self._types
        if type_hash not in self._editions:
            edition = self._types.matching(self.type, type_hash)
            if edition is None:
                raise DefinitionMismatch(self.topic, self.type, type_hash, self._types.type_hash(self.type))
            self._editions[type_hash] = edition
        return self._editions[type_hash]

    def learn(self, type_hash: str, types: TypeStore) -> None:
        """Take definitions for messages of senders whose definition has a hash."""
        self._editions[type_hash] = types

    def take_in(self, sample: Sample) -> None:
        """Take in what has been published; called on a thread of Zenoh's."""
        self._waiting.put(self._open(sample), len(sample.payload))

    def close(self) -> None:
        """Take nothing in any more; what waits can still be received."""
        self._waiting.close()

    def _open(self, sample: Sample) -> Received:
        type_hash = self._dialect.type_hash(sample.key)
        try:
            beside = Attachment.parse(sample.attachment)
        except InvalidAttachment:
            return Received(sample.payload, sample.arrived, None, None, b"", type_hash)
        self._count(beside)
        return Received(sample.payload, sample.arrived, beside.stamp, beside.sequence, beside.gid, type_hash)

    def _count(self, beside: Attachment) -> None:
        last = self._last.pop(beside.gid, None)
        self._last[beside.gid] = beside.sequence
        if last is None:
            if len(self._last) > MOST_SENDERS:
                del self._last[next(iter(self._last))]
        elif beside.sequence > last + 1:
            self._missed += beside.sequence - last - 1
            if self._first_missed is None:
                self._first_missed = last + 1
