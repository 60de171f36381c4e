"""The only module that imports zenoh: sessions, requests and liveliness, out of Zenoh's threads.

Zenoh has no asyncio interface, and calls back on its own receiving threads. What was learned about it
shapes this module: callbacks are direct (an indirect one costs a thread and makes the process hang at exit), do
no more than copy bytes into a bounded queue or wake the event loop, and never call back into Zenoh's
blocking functions; opening, declaring and closing happen in worker threads with a deadline; every query
object is released as soon as it is answered, because a client waits as long as one is alive.

`Session` is thread-neutral and is what a simulator node uses; `AsyncSession` is its face to asyncio.
"""

from __future__ import annotations

import asyncio
import json
import queue
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import anyio
import anyio.to_thread
import zenoh
from zenoh.handlers import Callback

CLOSE_DEADLINE = 2.0  # [s]
LEASE = 15_000  # [ms] that a peer may be silent; one that has died is noticed by the end of its connection
PATIENCE = 1_000_000  # [us] that what is sent may wait for its turn, before it is lost
INBOX_SIZE = 256
TOKEN_QUEUE_SIZE = 1024


class SessionError(Exception):
    """Nothing could be sent: the session did not open, or it is closed."""


class NoServer(SessionError):
    """Nobody serves the key that was asked."""


class NoAnswer(SessionError):
    """The server took longer than the timeout, or went away while it had the request."""


class Refused(SessionError):
    """The server answered with an error; `payload` is what it sent."""

    def __init__(self, payload: bytes) -> None:
        super().__init__("the request was refused")
        self.payload = payload


@dataclass(frozen=True)
class Request:
    """A query that arrived. Answer it exactly once, from any thread."""

    key: str
    payload: bytes
    _query: zenoh.Query = field(repr=False)

    def reply(self, payload: bytes) -> None:
        """Answer."""
        with self._query:
            self._query.reply(self.key, payload)

    def refuse(self, payload: bytes) -> None:
        """Answer with an error."""
        with self._query:
            self._query.reply_err(payload)


class Session:
    """A Zenoh session with seoro's settings: no multicast, no gossip, no shared memory, loopback or a socket file.

    Args:
        listen: Endpoint to listen on; the session is then the hub (a router).
        connect: Endpoint of the hub to connect to, as a client.

    Raises:
        SessionError: Exactly one of the two has to be given, and the endpoint has to work.
    """

    def __init__(self, *, listen: str | None = None, connect: str | None = None) -> None:
        if (listen is None) == (connect is None):
            raise SessionError("a session either listens or connects")
        self._tokens: list[Any] = []
        self._queryables: list[Any] = []
        try:
            self._zenoh = zenoh.open(zenoh.Config.from_json5(json.dumps(_settings(listen, connect))))
        except zenoh.ZError as error:
            endpoint = listen or connect
            reason = str(error).partition(" at /")[0]  # where in Zenoh's sources it was raised helps nobody
            raise SessionError(f"cannot {'listen on' if listen else 'connect to'} {endpoint}: {reason}") from error

    def serve(self, key: str, busy: bytes) -> queue.SimpleQueue[Request]:
        """Serve a key expression: requests arrive in the queue in the order they were sent.

        Args:
            key: A key expression, wildcards included.
            busy: The error answer to requests that find the queue full.
        """
        inbox: queue.SimpleQueue[Request] = queue.SimpleQueue()  # it costs a round trip 0.1 ms less than a `Queue`

        def take(query: zenoh.Query) -> None:
            payload = query.payload
            request = Request(str(query.key_expr), payload.to_bytes() if payload is not None else b"", query)
            if inbox.qsize() < INBOX_SIZE:
                inbox.put(request)
            else:
                request.refuse(busy)

        self._queryables.append(self._zenoh.declare_queryable(key, Callback(take, indirect=False), complete=True))
        return inbox

    def declare_token(self, key: str) -> None:
        """Be visible as alive under a key until the session closes or the process dies."""
        self._tokens.append(self._zenoh.liveliness().declare_token(key))

    def get(self, key: str, payload: bytes, timeout: float, done: Callable[[Reply], None]) -> Callable[[], None]:
        """Ask; `done` is called once, on a thread of Zenoh's. Returns what cancels the request."""
        answers: list[tuple[bool, bytes]] = []

        def take(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                answers.append((True, reply.ok.payload.to_bytes()))
            elif reply.err is not None:
                answers.append((False, reply.err.payload.to_bytes()))

        token = zenoh.CancellationToken()
        try:
            self._zenoh.get(
                key,
                Callback(take, drop=lambda: done(Reply(tuple(answers))), indirect=False),
                payload=payload,
                timeout=timeout,
                target=zenoh.QueryTarget.BEST_MATCHING,
                congestion_control=zenoh.CongestionControl.DROP,
                cancellation_token=token,
            )
        except zenoh.ZError as error:
            raise SessionError(f"cannot ask {key}: {error}") from error
        return token.cancel

    def watch_tokens(self, key: str, changed: Callable[[str, bool], None]) -> Callable[[], None]:
        """Call `changed(token, alive)` on a thread of Zenoh's, for present tokens and each change."""

        def take(sample: zenoh.Sample) -> None:
            changed(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        subscriber = self._zenoh.liveliness().declare_subscriber(key, Callback(take, indirect=False), history=True)
        undeclare: Callable[[], None] = subscriber.undeclare
        return undeclare

    def close(self) -> None:
        """Close, within `CLOSE_DEADLINE`; a session that hangs in closing is left to the end of the process."""
        closing = threading.Thread(target=self._zenoh.close, daemon=True)
        closing.start()
        closing.join(CLOSE_DEADLINE)


@dataclass(frozen=True)
class Reply:
    """What came back for one request: (ok, payload) of every answer."""

    answers: tuple[tuple[bool, bytes], ...]

    def value(self, key: str) -> bytes:
        """The one answer.

        Raises:
            NoServer, NoAnswer, Refused: There is none.
        """
        if not self.answers:
            raise NoServer(f"nobody serves {key}")
        ok, payload = self.answers[-1]
        if ok:
            return payload
        if payload == b"Timeout":  # Zenoh's own words for a query that was not answered in time
            raise NoAnswer(f"no answer from {key} in time")
        raise Refused(payload)


class AsyncSession:
    """A session for asyncio. Open it with `open_session`."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._pending: set[Callable[[], None]] = set()

    def abandon(self) -> None:
        """Give up all requests that wait for an answer, because there will be none; they end with `NoServer`."""
        for cancel in list(self._pending):
            cancel()

    async def query(self, key: str, payload: bytes, timeout: float) -> bytes:
        """Ask one server and wait for its answer.

        Args:
            key: Key that it serves.
            payload: The request.
            timeout: [s] of the machine's clock.

        Raises:
            NoServer, NoAnswer, Refused: There is no answer, or an error.
        """
        loop = asyncio.get_running_loop()
        future: asyncio.Future[Reply] = loop.create_future()

        def settle(reply: Reply) -> None:
            if not future.done():
                future.set_result(reply)

        def done(reply: Reply) -> None:
            # The loop may be gone when a late answer arrives at the end of the process.
            if not loop.is_closed():
                loop.call_soon_threadsafe(settle, reply)

        cancel = self._session.get(key, payload, timeout, done)
        self._pending.add(cancel)
        try:
            reply = await future
        except asyncio.CancelledError:
            cancel()
            raise
        finally:
            self._pending.discard(cancel)
        return reply.value(key)

    @asynccontextmanager
    async def tokens(self, key: str) -> AsyncIterator[AsyncIterator[tuple[str, bool]]]:
        """Follow liveliness: (token, alive) for those present and for each change."""
        loop = asyncio.get_running_loop()
        changes: asyncio.Queue[tuple[str, bool]] = asyncio.Queue(TOKEN_QUEUE_SIZE)

        def changed(token: str, alive: bool) -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(changes.put_nowait, (token, alive))

        async def follow() -> AsyncIterator[tuple[str, bool]]:
            while True:
                yield await changes.get()

        undeclare = await anyio.to_thread.run_sync(self._session.watch_tokens, key, changed)
        try:
            yield follow()
        finally:
            with anyio.CancelScope(shield=True):
                await anyio.to_thread.run_sync(undeclare)


@asynccontextmanager
async def open_session(*, listen: str | None = None, connect: str | None = None) -> AsyncIterator[AsyncSession]:
    """Open a session in a worker thread, and close it on every path."""
    opening = asyncio.ensure_future(anyio.to_thread.run_sync(partial(Session, listen=listen, connect=connect)))
    try:
        opened = await asyncio.shield(opening)
    except asyncio.CancelledError:
        # The thread opens it all the same, and nobody would close it.
        with anyio.CancelScope(shield=True), suppress(SessionError):
            await anyio.to_thread.run_sync((await opening).close)
        raise
    try:
        yield AsyncSession(opened)
    finally:
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(opened.close)


def _settings(listen: str | None, connect: str | None) -> dict[str, Any]:
    """The configuration of a session; both ends agree on the lease, by which a silent peer is given up."""
    # Zenoh sends answers as their requests were sent: what finds no room in time is lost. To have it wait for ever
    # would hold up the event loop by a peer that stands still; by Zenoh's own limit of 50 ms, busy machines lose
    # one large answer in a hundred.
    patience = {"wait_before_drop": PATIENCE, "max_wait_before_drop_fragments": PATIENCE}
    queue = {"congestion_control": {"drop": patience}}
    settings: dict[str, Any] = {
        "mode": "router" if listen else "client",
        "listen": {"endpoints": [listen] if listen else []},
        "connect": {
            "endpoints": [connect] if connect else [],
            "timeout_ms": 1000,
            "exit_on_failure": True,
            "retry": {"period_init_ms": 100, "period_max_ms": 500},
        },
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}, "delay": 20},
        "timestamping": {"enabled": True},
        "transport": {"shared_memory": {"enabled": False}, "link": {"tx": {"lease": LEASE, "queue": queue}}},
    }
    return settings
