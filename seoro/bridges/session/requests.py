"""Requests as they arrive: what is too much is refused before a byte of it is copied.

The thread of Zenoh's that calls back serves other connections, too. So it waits for nobody: refusals are sent by a
thread of their own, since one who asks and takes no answers holds up whoever answers.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING, Any, Final, Protocol

import zenoh

if TYPE_CHECKING:
    from seoro.keys.window import HolderKey

PART: Final = b"part"  # goes beside a part of an answer that need not be authentic
MOST_REFUSALS: Final = 1024  # that wait to be sent; more are sent by the thread on which they arise
MOST_BESIDE: Final = 8192  # [bytes] beside a request
KEPT: Final = 1 << 20  # [bytes] of a request that may wait for its refusal to be sent


class Form(IntEnum):
    """Forms of answers."""

    ANSWER = 0  # the only one, or the last
    PART = 1  # another one comes
    REFUSAL = 2


class Envelope(Protocol):
    """Envelope of a request: authenticates the request and its answers; from any thread."""

    def attest(self, request: bytes, form: int, number: int, answer: bytes) -> bytes:
        """Return what makes an answer authentic, from the request, and the form and number of the answer."""
        ...

    def check(self, holder: HolderKey, request: bytes) -> None:
        """Check that a client that holds robots has sent the request, for the first time.

        Raises:
            InvalidKeys: It has not.
        """
        ...


class Attestor(Protocol):
    """Makes answers authentic; from any thread."""

    def open(self, key: str, beside: bytes) -> tuple[bytes, Envelope | None]:
        """Split what is beside a request: return the rest of it, and its envelope, if it has one."""
        ...


class Intake(Protocol):
    """Decides which requests are accepted; from any thread, without waiting."""

    def admit(self, key: str, size: int, beside: bytes) -> bytes:
        """Count a request, and return nothing, or return the error answer to one that is not accepted.

        Args:
            key: Its key.
            size: Of its payload [bytes], of which nothing was read.
            beside: What travels beside it.
        """
        ...

    def end(self, key: str, size: int, beside: bytes) -> None:
        """Note that an accepted request has its answer."""
        ...

    def divert(self, request: Request) -> bool:
        """Take a request that must not wait in the queue of the others; False for all others."""
        ...


class Everything:
    """Accepts every request."""

    def admit(self, _key: str, _size: int, _beside: bytes) -> bytes:
        """Accept it."""
        return b""

    def end(self, _key: str, _size: int, _beside: bytes) -> None:
        """Nothing is counted."""

    def divert(self, _request: Request) -> bool:
        """Leave it in the queue."""
        return False


@dataclass(frozen=True)
class Request:
    """A query that arrived, with what came beside its payload. Answer it exactly once, from any thread.

    Attributes:
        key: Key that it asks.
        size: Of its payload [bytes].
        attachment: What came beside it, without its envelope.
        envelope: In which it came, if its answer has to be authentic.
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
        return _bytes(self._query.payload)

    def reply(self, payload: bytes, attachment: bytes | None = None) -> None:
        """Answer.

        Args:
            payload: The answer.
            attachment: What travels beside an answer that need not be authentic.
        """
        try:
            with self._query:
                self._reply(Form.ANSWER, payload, attachment)
        finally:
            self._end(self.key, self.size, self.attachment)

    def reply_part(self, payload: bytes) -> None:
        """Answer in part, before the answer itself; only to those who ask for parts."""
        self._reply(Form.PART, payload, PART)

    def drop(self) -> None:
        """Refuse without an answer: clients see that no node serves the key any more."""
        try:
            with self._query:
                pass
        finally:
            self._end(self.key, self.size, self.attachment)

    def refuse(self, payload: bytes) -> None:
        """Answer with an error."""
        try:
            with self._query:
                if self.envelope is None:
                    self._query.reply_err(payload)
                else:  # nothing travels beside errors
                    self._reply(Form.REFUSAL, payload, None)
        finally:
            self._end(self.key, self.size, self.attachment)

    def _reply(self, form: Form, payload: bytes, beside: bytes | None) -> None:
        if self.envelope is not None:
            beside = self.envelope.attest(self.payload, form, next(self._numbers), payload)
        self._query.reply(self.key, payload, attachment=beside)


class Refuser:
    """Sends refusals on a thread of its own."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[tuple[Any, bytes] | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._starting = threading.Lock()

    def refuse(self, query: Any, size: int, payload: bytes) -> None:
        """Answer a query with an error, soon.

        Args:
            query: Zenoh's.
            size: Of the payload [bytes]; large ones are freed at once.
            payload: The error.
        """
        if size > KEPT or self._waiting.qsize() >= MOST_REFUSALS:
            _refuse(query, payload)
            return
        self._waiting.put((query, payload))
        with self._starting:
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="refuses requests", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """End the thread, once it has sent what waits."""
        self._waiting.put(None)

    def _work(self) -> None:
        while (item := self._waiting.get()) is not None:
            _refuse(*item)


def receiver(
    intake: Intake,
    refuser: Refuser,
    take: Callable[[Request], bool | None],
    busy: bytes,
    attestor: Attestor | None = None,
) -> Callable[[Any], None]:
    """Make what Zenoh calls with each query.

    Args:
        intake: Decides which are accepted.
        refuser: Refuses the others.
        take: Takes a request; False if there is no room for it.
        busy: The error answer then.
        attestor: Makes answers authentic, except refusals of requests that are not accepted.
    """

    def receive(query: zenoh.Query) -> None:
        key, size = str(query.key_expr), 0 if query.payload is None else len(query.payload)
        attachment = query.attachment
        beside = b"" if attachment is None or len(attachment) > MOST_BESIDE else attachment.to_bytes()
        envelope = None
        if attestor is not None:
            beside, envelope = attestor.open(key, beside)
        if refusal := intake.admit(key, size, beside):
            refuser.refuse(query, size, refusal)
            return
        request = Request(key, size, beside, query, intake.end, envelope)
        if not intake.divert(request) and take(request) is False:
            intake.end(key, size, beside)
            refuser.refuse(query, size, busy)

    return receive


def _refuse(query: Any, payload: bytes) -> None:
    with suppress(zenoh.ZError), query:  # whoever asked may be gone
        query.reply_err(payload)


def _bytes(content: zenoh.ZBytes | None) -> bytes:
    return b"" if content is None else content.to_bytes()
