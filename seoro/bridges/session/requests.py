"""Received requests, of which excessive ones are refused before their payload is copied.

Callbacks run on a thread of Zenoh that serves other connections, too, so they must not wait. A client that does
not read its answers blocks the sender, so refusals are sent by a thread of their own.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import field
from enum import IntEnum
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING, Any, Final

import zenoh

from seoro.deferred import dataclass

if TYPE_CHECKING:
    from seoro.security.signing.answers import AnswerSigner, Envelope

PART: Final = b"part"  # attachment of a part of an answer that need not be authentic
MAX_REFUSALS: Final = 1024  # size of the queue of refusals; further ones are sent by their own thread
MAX_ATTACHMENT: Final = 8192  # [bytes], of a request
KEPT: Final = 1 << 20  # [bytes] largest request that waits in the queue of refusals


class Form(IntEnum):
    """Forms of answers."""

    ANSWER = 0  # the only or last answer
    PART = 1  # more answers follow
    REFUSAL = 2


class AdmissionPolicy:
    """Decides which requests are accepted, from any thread, without waiting; this one accepts all."""

    def admit(self, key: str, size: int, attachment: bytes) -> bytes:
        """Accept a request, or return its error answer; an accepted one returns empty bytes.

        Args:
            key: Key of the request.
            size: Size of its unread payload [bytes].
            attachment: Attachment of the request.
        """
        return b""

    def end(self, key: str, size: int, attachment: bytes) -> None:
        """Record that an accepted request was answered."""

    def divert(self, request: Request) -> bool:
        """Handle a request that must not wait in the common queue; False for all others."""
        return False


@dataclass(frozen=True)
class Request:
    """A received request. Answer it exactly once, from any thread.

    Attributes:
        key: Key of the request.
        size: Size of its payload [bytes].
        attachment: Attachment, without its envelope.
        envelope: Envelope, if the answer has to be authentic.
    """

    key: str
    size: int
    attachment: bytes
    _query: Any = field(repr=False)
    _end: Callable[[str, int, bytes], None] = field(repr=False)
    envelope: Envelope | None = field(default=None, repr=False)
    _numbers: count[int] = field(default_factory=count, repr=False)

    @cached_property
    def payload(self) -> bytes:
        """The payload, copied from Zenoh's memory at the first access."""
        return to_bytes(self._query.payload)

    def reply(self, payload: bytes, attachment: bytes | None = None) -> None:
        """Send the answer.

        Args:
            payload: The answer.
            attachment: Attachment of an answer that need not be authentic.
        """
        with self._ending():
            self._reply(Form.ANSWER, payload, attachment)

    def reply_part(self, payload: bytes) -> None:
        """Send a part of the answer, before the answer itself; only to clients of `query_parts`."""
        self._reply(Form.PART, payload, PART)

    def drop(self) -> None:
        """Refuse without an answer: clients see that no node serves the key any more."""
        with self._ending():
            pass

    def refuse(self, payload: bytes) -> None:
        """Send an error as the answer."""
        with self._ending():
            if self.envelope is None:
                self._query.reply_err(payload)
            else:  # errors have no attachment
                self._reply(Form.REFUSAL, payload, None)

    @contextmanager
    def _ending(self) -> Iterator[None]:
        """Release the query after the block, and report its end."""
        try:
            with self._query:
                yield
        finally:
            self._end(self.key, self.size, self.attachment)

    def _reply(self, form: Form, payload: bytes, attachment: bytes | None) -> None:
        if self.envelope is not None:
            attachment = self.envelope.attest(self.payload, form, next(self._numbers), payload)
        self._query.reply(self.key, payload, attachment=attachment)


class Refuser:
    """Sender of refusals, with a thread of its own."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[tuple[Any, bytes] | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._starting = threading.Lock()

    def refuse(self, query: Any, size: int, payload: bytes) -> None:
        """Answer a query with an error, soon.

        Args:
            query: Zenoh's query.
            size: Size of its payload [bytes]; large ones are refused at once, to free their memory.
            payload: The error.
        """
        if size > KEPT or self._waiting.qsize() >= MAX_REFUSALS:
            _refuse(query, payload)
            return
        self._waiting.put((query, payload))
        with self._starting:
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="refusals of requests", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """End the thread after the queued refusals."""
        self._waiting.put(None)

    def _work(self) -> None:
        while (item := self._waiting.get()) is not None:
            _refuse(*item)


def receiver(
    intake: AdmissionPolicy,
    refuser: Refuser,
    take: Callable[[Request], bool | None],
    busy: bytes,
    attestor: AnswerSigner | None = None,
) -> Callable[[Any], None]:
    """Return the callback for Zenoh's queries.

    Args:
        intake: Decides which requests are accepted.
        refuser: Refuses the others.
        take: Queues a request; False if the queue is full.
        busy: Error answer for a full queue.
        attestor: Makes answers authentic, except refusals of requests that are not accepted.
    """

    def receive(query: zenoh.Query) -> None:
        key, size = str(query.key_expr), 0 if query.payload is None else len(query.payload)
        attachment, envelope = to_bytes(query.attachment, MAX_ATTACHMENT), None
        if attestor is not None:
            attachment, envelope = attestor.open(key, attachment)
        if refusal := intake.admit(key, size, attachment):
            refuser.refuse(query, size, refusal)
            return
        request = Request(key, size, attachment, query, intake.end, envelope)
        if not intake.divert(request) and take(request) is False:
            intake.end(key, size, attachment)
            refuser.refuse(query, size, busy)

    return receive


def _refuse(query: Any, payload: bytes) -> None:
    with suppress(zenoh.ZError), query:  # the client may be disconnected
        query.reply_err(payload)


def to_bytes(content: zenoh.ZBytes | None, largest: int | None = None) -> bytes:
    """Copy from Zenoh's memory; empty if the content is missing, or larger than `largest` [bytes]."""
    if content is None or (largest is not None and len(content) > largest):
        return b""
    return content.to_bytes()
