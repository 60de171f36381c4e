"""Publishers and subscriptions of ROS 2 topics."""

from __future__ import annotations

import itertools
import time
from collections.abc import AsyncIterator, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import anyio

from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.interfaces import InvalidPayload, Message, TypeStore
from seoro.bridges.ros2.wire import Attachment, Dialect, Qos
from seoro.bridges.session import Bound, Mailbox, Publisher, Sample
from seoro.errors import BackendError, UsageError

KEEP_ALL = Bound(10_000)  # queue of a subscription with the history policy "keep all"
MAX_SENDERS = 1024  # number of senders whose sequence numbers are tracked


@dataclass(eq=False)
class Publication:
    """Publisher of a topic. Made by `RosNode.publishing`.

    Attributes:
        topic: Full name of the topic.
        type: Full name of the type of the messages.
        qos: Offered QoS.
    """

    topic: str
    type: str
    qos: Qos
    _publisher: Publisher
    _dialect: Dialect
    _gid: bytes
    _types: TypeStore
    _check: Callable[[], object]
    _numbers: itertools.count[int] = field(default_factory=lambda: itertools.count(1))

    def publish(self, value: Mapping[str, Any] | Message) -> None:
        """Publish a message without waiting; missing members have the defaults of the definition.

        Raises:
            InvalidValue: The message does not fit the type.
            SessionError: The session is closed.
        """
        self.send(self._types.encode(self.type, value))

    async def wait_for_subscription(self, timeout: float | None = None) -> None:
        """Wait until messages reach a subscription; return at once if late subscriptions get earlier messages.

        Args:
            timeout: Time limit [s] of the machine's clock; None for no limit.

        Raises:
            WrongType, DefinitionMismatch: The subscriptions have another type, or another definition of it.
            TimeoutError: No subscription appeared in time.
        """
        try:
            with anyio.fail_after(timeout):
                await self._publisher.wait_for_subscriber()
        except TimeoutError:
            self._check()
            raise

    def send(self, payload: bytes) -> None:
        """Publish a message given as CDR with its header."""
        attachment = self._dialect.attachment(next(self._numbers), time.time_ns(), self._gid)
        self._publisher.put(payload, attachment)


class ReceivedPayload(NamedTuple):
    """A received message, not decoded.

    Attributes:
        payload: CDR, with its header.
        arrived: Time of arrival [ns since the epoch], by the clock of this machine.
        sent: Time of sending [ns since the epoch], by the clock of the sender; None if unknown.
        sequence: Sequence number of the sender; None if unknown.
        sender: GID of the sender; empty if unknown.
        type_hash: Type hash of the sender; None if unknown.
    """

    payload: bytes
    arrived: int
    sent: int | None
    sequence: int | None
    sender: bytes
    type_hash: str | None


class Subscription:
    """Subscription to a topic. Made by `RosNode.subscribing`; iteration yields the received messages.

    Attributes:
        topic: Full name of the topic.
        type: Full name of the type of the messages.
        missed: Number of messages lost in transit, by the sequence numbers of the senders.
        first_missed: Sequence number of the first message lost in transit; None if none was lost.
    """

    def __init__(self, topic: str, type_name: str, bound: Bound, dialect: Dialect, types: TypeStore) -> None:
        self.topic = topic
        self.type = type_name
        self._waiting: Mailbox[ReceivedPayload] = Mailbox(bound)
        self.missed = 0
        self.first_missed: int | None = None
        self._dialect = dialect
        self._types = types
        self._last: dict[bytes, int] = {}
        self._editions: dict[str, TypeStore] = {}

    @property
    def unread(self) -> int:
        """Number of messages that wait to be received."""
        return len(self._waiting)

    @property
    def lost(self) -> int:
        """Number of messages that arrived and were dropped from the full queue."""
        return self._waiting.dropped

    async def receive(self) -> ReceivedPayload:
        """Wait for the next message.

        Raises:
            Closed: The subscription has ended.
        """
        return await self._waiting.get()

    async def message(self) -> Message:
        """Wait for the next message, and decode it.

        Raises:
            Closed: The subscription has ended.
            InvalidPayload: The payload is not a message of the type.
            DefinitionMismatch: The sender has another definition of the type.
        """
        return self.decode(await self.receive())

    def receive_nowait(self) -> ReceivedPayload | None:
        """Return the oldest unread message, or None."""
        return self._waiting.get_nowait()

    def on_arrival(self, call: Callable[[], None]) -> None:
        """Call a function once, soon after a message arrives or the subscription closes."""
        self._waiting.on_arrival(call)

    def __aiter__(self) -> AsyncIterator[ReceivedPayload]:
        return aiter(self._waiting)

    async def decoded(self, on_error: Callable[[str], None]) -> AsyncIterator[tuple[ReceivedPayload, Message]]:
        """Yield messages with their decoded values; skip undecodable ones, and report the first of each kind."""
        reported: set[type[Exception]] = set()
        async for received in self:
            try:
                message = self.decode(received)
            except (BackendError, UsageError) as error:
                if type(error) not in reported:
                    on_error(str(error))
                reported.add(type(error))
            else:
                yield received, message

    def decode(self, received: ReceivedPayload) -> Message:
        """Decode a message.

        Raises:
            InvalidPayload: The payload is not a message of the type.
            DefinitionMismatch: The sender has another definition of the type.
        """
        types = self._types_of(received.type_hash)
        try:
            return types.decode(self.type, received.payload)
        except InvalidPayload as error:
            raise InvalidPayload(f"invalid message on {self.topic}: {error}") from error

    def _types_of(self, type_hash: str | None) -> TypeStore:
        """Return the definitions of a sender; those of seoro if it does not announce a hash."""
        if type_hash is None:
            return self._types
        if type_hash not in self._editions:
            edition = self._types.matching(self.type, type_hash)
            if edition is None:
                raise DefinitionMismatch(self.topic, self.type, type_hash, self._types.type_hash(self.type))
            self._editions[type_hash] = edition
        return self._editions[type_hash]

    def add_types(self, type_hash: str, types: TypeStore) -> None:
        """Add the definitions for messages with a type hash."""
        self._editions[type_hash] = types

    def on_sample(self, sample: Sample) -> None:
        """Queue a published message; called on a thread of Zenoh."""
        self._waiting.put(self._unpack(sample), len(sample.payload))

    def close(self) -> None:
        """Queue no more messages; queued ones can still be received."""
        self._waiting.close()

    def _unpack(self, sample: Sample) -> ReceivedPayload:
        type_hash = self._dialect.type_hash(sample.key)
        attachment = Attachment.parse(sample.attachment)
        if attachment is None:
            return ReceivedPayload(sample.payload, sample.arrived, None, None, b"", type_hash)
        self._count_missed(attachment)
        sequence, stamp, gid = attachment
        return ReceivedPayload(sample.payload, sample.arrived, stamp, sequence, gid, type_hash)

    def _count_missed(self, attachment: Attachment) -> None:
        last = self._last.pop(attachment.gid, None)
        self._last[attachment.gid] = attachment.sequence
        if last is None:
            if len(self._last) > MAX_SENDERS:
                del self._last[next(iter(self._last))]
        elif attachment.sequence > last + 1:
            self.missed += attachment.sequence - last - 1
            if self.first_missed is None:
                self.first_missed = last + 1
