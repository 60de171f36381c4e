"""Sessions for asyncio: what Zenoh's threads have goes to the event loop, and what blocks is done by others."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import Final, NamedTuple, TypeAlias

import anyio.to_thread
import zenoh
from zenoh.handlers import Callback

from seoro.bridges.session.core import EVERYTHING, LARGEST, Session
from seoro.bridges.session.declaring import declared
from seoro.bridges.session.errors import NoAnswer, NoServer, NotAuthentic, Refused
from seoro.bridges.session.mailbox import Bound, Mailbox
from seoro.bridges.session.requests import PART, Attestor, Form, Intake, Request
from seoro.bridges.session.security import Security

_TIMEOUT: Final = b"Timeout"  # Zenoh's own words for a query that was not answered in time
TOKEN_BOUND = Bound(1 << 16, lose="newest")  # changes that wait to be looked at


class Answer(NamedTuple):
    """An answer as it arrived.

    Attributes:
        is_ok: Whether it is no error of Zenoh's.
        payload: What it says.
        beside: What came beside it.
    """

    is_ok: bool
    payload: bytes
    beside: bytes = b""


Check: TypeAlias = Callable[[Answer], Form]
"""Returns the form of an answer, or raises `NotAuthentic`."""


def form_of(answer: Answer) -> Form:
    """Form of an answer that need not be authentic."""
    if not answer.is_ok:
        return Form.REFUSAL
    return Form.PART if answer.beside == PART else Form.ANSWER


@dataclass(frozen=True)
class Reply:
    """What came back for one request."""

    answers: tuple[Answer, ...]

    def value(self, key: str, check: Check = form_of) -> bytes:
        """The one answer: the last, or the last one that is authentic.

        Raises:
            NoServer, NoAnswer, Refused, NotAuthentic: There is none.
        """
        return self.formed(key, check)[1]

    def formed(self, key: str, check: Check = form_of) -> tuple[Form, bytes]:
        """The same with its form."""
        doubt: NotAuthentic | None = None
        for answer in reversed(self.answers):
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
        raise doubt or NoServer(f"nobody serves {key}")


def arrived(reply: zenoh.Reply) -> Answer | None:
    """Copy what has arrived, on a thread of Zenoh's."""
    if reply.ok is not None:
        beside = reply.ok.attachment
        return Answer(True, reply.ok.payload.to_bytes(), b"" if beside is None else beside.to_bytes())
    return None if reply.err is None else Answer(False, reply.err.payload.to_bytes())


class AsyncSession:
    """A session for asyncio. Open it with `open_session`."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._pending: set[Callable[[], None]] = set()

    @property
    def blocking(self) -> Session:
        """The same session for worker threads."""
        return self._session

    @property
    def identity(self) -> str:
        """What this session is called in tokens: Zenoh's id of it."""
        return str(self._session.handle.zid())

    @property
    def is_cut_off(self) -> bool:
        """Whether the connection is lost, and was not made again yet."""
        return self._session.is_cut_off

    def abandon(self) -> None:
        """Give up all requests that wait for an answer, because there will be none; they end with `NoServer`."""
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
        """Ask one server and wait for its answer.

        Args:
            key: Key that it serves.
            payload: The request.
            timeout: [s] of the machine's clock.
            attachment: What travels beside the payload.
            check: Checks that the answer is authentic.
            is_urgent: Whether it overtakes everything else on its way.

        Raises:
            NoServer, NoAnswer, Refused, NotAuthentic: There is no answer, or an error.
        """
        return (await self._asked(key, payload, timeout, attachment, is_urgent=is_urgent)).value(key, check)

    async def query_others(self, key: str, payload: bytes, timeout: float) -> tuple[bytes, ...]:
        """Ask all other sessions that serve a key; returns the answers that came in time.

        Args:
            key: The key.
            payload: The request.
            timeout: [s] of the machine's clock.
        """
        reply = await self._asked(key, payload, timeout, None, to_others=True)
        return tuple(answer.payload for answer in reply.answers if answer.is_ok)

    async def _asked(
        self,
        key: str,
        payload: bytes,
        timeout: float,
        attachment: bytes | None,
        *,
        to_others: bool = False,
        is_urgent: bool = False,
    ) -> Reply:
        loop = asyncio.get_running_loop()
        future: asyncio.Future[Reply] = loop.create_future()
        answers: list[Answer] = []

        def take(reply: zenoh.Reply) -> None:
            if (answer := arrived(reply)) is not None:
                answers.append(answer)

        def settle(reply: Reply) -> None:
            if not future.done():
                future.set_result(reply)

        def over() -> None:
            # The loop may be gone when a late answer arrives at the end of the process.
            if not loop.is_closed():
                loop.call_soon_threadsafe(settle, Reply(tuple(answers)))

        consolidation = zenoh.ConsolidationMode.NONE if to_others else zenoh.ConsolidationMode.AUTO
        answered = Callback(take, drop=over, indirect=False)
        cancel = self._session.get(
            key,
            payload,
            timeout,
            answered,
            attachment,
            consolidation,
            to_others=to_others,
            is_urgent=is_urgent,
        )
        self._pending.add(cancel)
        try:
            reply = await future
        except asyncio.CancelledError:
            cancel()
            raise
        finally:
            self._pending.discard(cancel)
        return reply

    @asynccontextmanager
    async def tokens(self, key: str) -> AsyncIterator[AsyncIterator[tuple[str, bool]]]:
        """Follow liveliness: (token, alive) for those present and for each change."""
        async with self.token_changes(key) as changes:
            yield aiter(changes)

    @asynccontextmanager
    async def token_changes(self, key: str) -> AsyncIterator[Mailbox[tuple[str, bool]]]:
        """The same as `tokens`, for those who take many changes at once."""
        changes: Mailbox[tuple[str, bool]] = Mailbox(TOKEN_BOUND)

        def changed(token: str, alive: bool) -> None:
            changes.put((token, alive), len(token))

        async with declared(partial(self._session.watch_tokens, key, changed), _undeclare):
            try:
                yield changes
            finally:
                changes.close()

    @asynccontextmanager
    async def token(self, key: str) -> AsyncIterator[None]:
        """Be visible as alive under a key for as long as the block lasts."""
        async with declared(partial(self._session.declare_token, key), _undeclare):
            yield

    async def list_tokens(self, key: str, timeout: float) -> frozenset[str]:
        """Who is alive under a key expression; waits for the hub's answer, `timeout` [s] at most."""
        return await anyio.to_thread.run_sync(self._session.list_tokens, key, timeout)

    @asynccontextmanager
    async def answering(
        self,
        key: str,
        bound: Bound,
        busy: bytes,
        intake: Intake = EVERYTHING,
        attestor: Attestor | None = None,
    ) -> AsyncIterator[Mailbox[Request]]:
        """Serve a key for as long as the block lasts.

        Args:
            key: The key.
            bound: How many requests wait.
            busy: The error answer to requests that find no room.
            intake: Decides which requests are accepted.
            attestor: Makes answers authentic.
        """
        requests: Mailbox[Request] = Mailbox(bound)

        def take(request: Request) -> bool:
            return requests.put(request, request.size)

        try:
            async with declared(partial(self._session.answer, key, take, busy, intake, attestor), _undeclare):
                yield requests
        finally:  # what comes until it is undeclared finds no answer either
            requests.close()
            while (request := requests.take_now()) is not None:
                request.drop()


@asynccontextmanager
async def open_session(
    *,
    listen: str | None = None,
    connect: str | None = None,
    patient: bool = True,
    security: Security | None = None,
    gossip: bool = False,
    as_peer: bool = False,
    largest: int = LARGEST,
) -> AsyncIterator[AsyncSession]:
    """Open a session in a worker thread, and close it on every path; see `Session` for the arguments."""
    make = partial(
        Session,
        listen=listen,
        connect=connect,
        patient=patient,
        security=security,
        gossip=gossip,
        as_peer=as_peer,
        largest=largest,
    )
    async with declared(make, Session.close) as opened:
        yield AsyncSession(opened)


def _undeclare(undeclare: Callable[[], None]) -> None:
    """Take back what was declared; a session that is closed has done so already."""
    with suppress(zenoh.ZError):
        undeclare()
