"""Sessions for asyncio: answers and messages reach the event loop, and blocking calls run in worker threads."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple, ParamSpec, TypeAlias

import anyio.to_thread
import zenoh
from zenoh.handlers import Callback

from seoro.bridges.session.core import EVERYTHING, Session
from seoro.bridges.session.declaring import declared, undeclare
from seoro.bridges.session.errors import NoAnswer, NoServer, NotAuthentic, Refused, Unanswered
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.reaching import PATIENCE, may_be_late
from seoro.bridges.session.requests import PART, AdmissionPolicy, Form, Request, to_bytes

if TYPE_CHECKING:
    from seoro.security.signing.answers import AnswerSigner

_TIMEOUT: Final = b"Timeout"  # Zenoh's error for a query without an answer in time
TOKEN_BOUND = Bound(1 << 16, drop="newest")  # unread changes of tokens
PART_BOUND = Bound(1 << 14)  # unread parts of an answer; the last part is never dropped

P = ParamSpec("P")


class Answer(NamedTuple):
    """An answer as it arrived.

    Attributes:
        is_ok: Whether it is an answer, and not an error.
        payload: Payload.
        attachment: Attachment; empty without one.
    """

    is_ok: bool
    payload: bytes
    attachment: bytes = b""


Check: TypeAlias = Callable[[Answer], Form]
"""Returns the form of an answer, or raises `NotAuthentic`."""


def form_of(answer: Answer) -> Form:
    """Return the form of an answer that need not be authentic."""
    if not answer.is_ok:
        return Form.REFUSAL
    return Form.PART if answer.attachment == PART else Form.ANSWER


def select_answer(answers: Sequence[Answer], key: str, check: Check = form_of) -> tuple[Form, bytes]:
    """Select the last authentic answer to a request; returns its form and payload.

    Raises:
        NoServer, NoAnswer, Refused, NotAuthentic: The answer is missing, or is an error.
    """
    doubt: NotAuthentic | None = None
    for answer in reversed(answers):
        if not answer.is_ok and answer.payload == _TIMEOUT:
            raise NoAnswer(f"no answer from {key} in time")
        try:
            form = check(answer)
        except NotAuthentic as error:
            doubt = error
            continue
        if form is Form.REFUSAL:
            raise Refused(answer.payload)
        return form, answer.payload
    raise doubt or NoServer(f"no server at {key}")


def _copied(reply: zenoh.Reply) -> list[Answer]:
    """Copy a reply from Zenoh's memory; empty for a reply without content."""
    if reply.ok is not None:
        return [Answer(True, reply.ok.payload.to_bytes(), to_bytes(reply.ok.attachment))]
    return [] if reply.err is None else [Answer(False, reply.err.payload.to_bytes())]


class AsyncSession:
    """A session for asyncio. Open it with `open_session`."""

    def __init__(self, session: Session) -> None:
        self.blocking: Final = session  # for worker threads
        self._pending: set[Callable[[], None]] = set()

    @property
    def identity(self) -> str:
        """Zenoh's id of this session, which its tokens contain."""
        return str(self.blocking.handle.zid())

    @property
    def is_cut_off(self) -> bool:
        """Whether the connection is lost, and not restored yet."""
        return self.blocking.is_cut_off

    def abandon(self) -> None:
        """Cancel all pending requests; they raise `NoServer`."""
        for cancel in list(self._pending):
            cancel()

    async def query(
        self,
        key: str,
        payload: bytes,
        timeout: float,
        attachment: bytes | None = None,
        *,
        check: Check = form_of,
        is_urgent: bool = False,
    ) -> bytes:
        """Send a request to one server and return its answer.

        Args:
            key: Key of the server.
            payload: The request.
            timeout: [s] of the machine's clock.
            attachment: Attachment of the request.
            check: Checks that the answer is authentic.
            is_urgent: Whether the request and its answer overtake all other messages.

        Raises:
            NoServer, NoAnswer, Refused, NotAuthentic: The answer is missing, or is an error.
        """
        answers = await self._answers(key, payload, timeout, attachment, is_urgent=is_urgent)
        return select_answer(answers, key, check)[1]

    async def query_others(self, key: str, payload: bytes, timeout: float) -> tuple[bytes, ...]:
        """Send a request to all other sessions that serve a key; returns the answers that came in time.

        Args:
            key: The key.
            payload: The request.
            timeout: [s] of the machine's clock.
        """
        answers = await self._answers(key, payload, timeout, None, to_others=True)
        return tuple(answer.payload for answer in answers if answer.is_ok)

    async def _answers(
        self,
        key: str,
        payload: bytes,
        timeout: float,
        attachment: bytes | None,
        *,
        to_others: bool = False,
        is_urgent: bool = False,
    ) -> list[Answer]:
        loop = asyncio.get_running_loop()
        future: asyncio.Future[None] = loop.create_future()
        answers: list[Answer] = []

        def settle() -> None:
            if not future.done():
                future.set_result(None)

        def finish() -> None:
            # The loop may be closed when a late answer arrives at the end of the process.
            if not loop.is_closed():
                loop.call_soon_threadsafe(settle)

        cancel = self.blocking.get(
            key,
            payload,
            timeout,
            Callback(lambda reply: answers.extend(_copied(reply)), drop=finish, indirect=False),
            attachment,
            zenoh.ConsolidationMode.NONE if to_others else zenoh.ConsolidationMode.AUTO,
            to_others=to_others,
            is_urgent=is_urgent,
        )
        self._pending.add(cancel)
        try:
            await future
        except asyncio.CancelledError:
            cancel()
            raise
        finally:
            self._pending.discard(cancel)
        return answers

    @asynccontextmanager
    async def tokens(self, key: str) -> AsyncIterator[Mailbox[tuple[str, bool]]]:
        """Follow liveliness: (token, alive) for present tokens and for each change."""
        changes: Mailbox[tuple[str, bool]] = Mailbox(TOKEN_BOUND)

        def changed(token: str, alive: bool) -> None:
            changes.put((token, alive), len(token))

        async with declared(partial(self.blocking.watch_tokens, key, changed), undeclare):
            try:
                yield changes
            finally:
                changes.close()

    @asynccontextmanager
    async def token(self, key: str) -> AsyncIterator[None]:
        """Declare a liveliness token while the block lasts."""
        async with declared(partial(self.blocking.declare_token, key), undeclare):
            yield

    async def list_tokens(self, key: str, timeout: float) -> frozenset[str]:
        """Return the live tokens of a key expression; waits for the hub's answer, `timeout` [s] at most."""
        return await anyio.to_thread.run_sync(self.blocking.list_tokens, key, timeout)

    @asynccontextmanager
    async def answering(
        self,
        key: str,
        bound: Bound,
        busy: bytes,
        intake: AdmissionPolicy = EVERYTHING,
        attestor: AnswerSigner | None = None,
    ) -> AsyncIterator[Mailbox[Request]]:
        """Serve a key while the block lasts.

        Args:
            key: The key.
            bound: Capacity of the queue of requests.
            busy: Error answer to requests that find the queue full.
            intake: Decides which requests are accepted.
            attestor: Makes answers authentic.
        """
        requests: Mailbox[Request] = Mailbox(bound)

        def take(request: Request) -> bool:
            return requests.put(request, request.size)

        try:
            async with declared(partial(self.blocking.answer, key, take, busy, intake, attestor), undeclare):
                yield requests
        finally:  # also requests that arrived before the end of the declaration
            requests.close()
            while (request := requests.get_nowait()) is not None:
                request.drop()


@asynccontextmanager
async def query_parts(
    session: AsyncSession,
    key: str,
    payload: bytes,
    timeout: float,
    attachment: bytes | None = None,
    check: Check = form_of,
) -> AsyncIterator[AsyncIterator[tuple[bool, bytes]]]:
    """Send a request whose answer comes in parts. The request is cancelled when the block ends.

    Parts get lost on a full link or with a slow receiver, so each part must contain its position.

    Args:
        session: Session of the client.
        key: Key of the server.
        payload: The request.
        timeout: [s] of the machine's clock, for the whole answer.
        attachment: Attachment of the request.
        check: Checks that parts and the answer are authentic.

    Yields:
        Whether it is a part, and its payload; the answer comes last. `NoServer`, `NoAnswer`, `Refused` or
        `NotAuthentic` is raised in its place.
    """
    arrived: Mailbox[list[Answer]] = Mailbox(PART_BOUND)

    def take(reply: zenoh.Reply) -> None:
        for answer in _copied(reply):
            arrived.put([answer], len(answer.payload))

    callback = Callback(take, drop=lambda: arrived.put([], 0), indirect=False)
    mode = zenoh.ConsolidationMode.NONE  # parts are passed on as they arrive
    cancel = session.blocking.get(key, payload, timeout, callback, attachment, mode)
    try:
        yield _parts(arrived, key, check)
    finally:
        cancel()


async def _parts(arrived: Mailbox[list[Answer]], key: str, check: Check) -> AsyncIterator[tuple[bool, bytes]]:
    is_part = True
    while is_part:
        form, payload = select_answer(await arrived.get(), key, check)
        is_part = form is Form.PART
        yield is_part, payload


def _opener(make: Callable[P, Session], patience: float) -> Callable[P, AbstractAsyncContextManager[AsyncSession]]:
    @asynccontextmanager
    async def open_session(*args: P.args, **options: P.kwargs) -> AsyncIterator[AsyncSession]:
        deadline = time.monotonic() + patience
        async with AsyncExitStack() as stack:
            while True:
                try:
                    opening = declared(partial(make, *args, **options), Session.close)
                    opened = await stack.enter_async_context(opening)
                    break
                except Unanswered:
                    if time.monotonic() > deadline or not await may_be_late(options.get("connect")):
                        raise
            yield AsyncSession(opened)

    return open_session


open_session = _opener(Session, PATIENCE)
"""Open a session in a worker thread, and close it on every path; see `Session` for the arguments.

A process that listens has 5 s to answer.
"""

open_session_at_once = _opener(Session, 0.0)
"""The same for callers that try again themselves: a process that listens has a second to answer."""
