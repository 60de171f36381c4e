"""Emergency stops of a server: a separate thread, and at a router a separate connection.

A stop is published, which also reaches servers that the sender does not know, and sent as a request. It takes
effect before its reply and its record.
"""

from __future__ import annotations

import logging
import queue
import sys
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import Future
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from functools import partial
from typing import TYPE_CHECKING, Final, TypeAlias

import anyio.to_thread

from seoro.bridges.serving.answering import refuse
from seoro.bridges.serving.heaps import limit_heaps
from seoro.bridges.session import AsyncSession, Request, declare_subscriber
from seoro.bridges.wire.authentication import DENIED
from seoro.bridges.wire.keys import emergency_key
from seoro.bridges.wire.lab import EMERGENCY_STOP, EmergencyStop, StopAcknowledgement
from seoro.bridges.wire.message import WireError, encode
from seoro.bridges.wire.refusal import RequestRefused
from seoro.security.keys.roles import MOVING, Role
from seoro.security.network.audit_trail import AuditedRequest
from seoro.security.network.listener import Listener

if TYPE_CHECKING:
    from seoro.security.keys.certificates import Identity
    from seoro.security.network.node_identity import NodeIdentity

SWITCH_INTERVAL: Final = 5e-4  # [s] between switches of threads; the default is 5 ms
MOST: Final = 256  # published stops in the queue
STOP: Final = EMERGENCY_STOP.name

Stop: TypeAlias = Callable[[EmergencyStop], "Future[StopAcknowledgement]"]
"""Stops robots before it returns, independently of other threads. The result is set when all robots have the
command.

It raises `RequestRefused` if all named robots are unknown.
"""

log = logging.getLogger(__name__)


class StopThread:
    """Executes emergency stops on a separate thread. Made by `stop_thread`.

    Args:
        identity: Identity of the server; None without keys, where every client may stop it.
        stop: Stops the robots or runs of the server.
        save: Called afterwards to save the stop.
        namespace: Namespace of the server.
    """

    def __init__(
        self, identity: NodeIdentity | None, stop: Stop, save: Callable[[], object], namespace: str
    ) -> None:
        self.key = emergency_key(namespace)
        self._identity = identity
        self._stop = stop
        self._save = save
        self._jobs: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="emergency stops", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread after the queued stops."""
        self._jobs.put(None)
        self._thread.join()

    def on_published(self, payload: bytes, signature: bytes) -> None:
        """Queue a published stop; from any thread."""
        if self._jobs.qsize() < MOST:
            self._jobs.put(
                partial(
                    self._obey, payload, lambda identity: identity.authenticate_stop(self.key, payload, signature)
                )
            )

    def on_request(self, request: Request) -> None:
        """Queue a request to stop; from any thread."""
        self._jobs.put(lambda: self._obey(request.payload, partial(_admit, request), request))

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                job()
            except Exception:
                log.exception("fault in an emergency stop")

    def _obey(
        self, payload: bytes, admit: Callable[[NodeIdentity], Identity], request: Request | None = None
    ) -> None:
        try:
            asked = self._admitted(payload, admit)
        except RequestRefused as refused:
            if request is not None:
                refuse(request, refused.code, refused.message)
            return
        try:
            stop = EMERGENCY_STOP.read(payload)
        except WireError:
            stop = EmergencyStop(by="a client with an unreadable message")
        try:
            stopped = self._stop(stop)
        except RequestRefused as refused:
            if request is not None:  # a published stop may be for robots of other nodes
                refuse(request, refused.code, refused.message)
                self._refuse(asked, refused)
            return
        stopped.add_done_callback(lambda done: self._jobs.put(partial(self._finish, asked, request, done)))

    def _admitted(self, payload: bytes, admit: Callable[[NodeIdentity], Identity]) -> AuditedRequest:
        """Authenticate the sender of a stop.

        Raises:
            RequestRefused: The sender may not stop the server.
        """
        asked = AuditedRequest(None, STOP, payload)
        if self._identity is None:
            return asked
        with self._identity.audit_trail.recorded_refusals(asked):
            asked.who = who = admit(self._identity)
            if who.role not in MOVING:
                raise RequestRefused(DENIED, f"{who} may not send `{STOP}` (required role: operator)")
        return asked

    def _refuse(self, asked: AuditedRequest, refused: RequestRefused) -> None:
        if self._identity is not None:
            self._identity.audit_trail.record_refusal(asked, refused.message)

    def _finish(
        self, asked: AuditedRequest, request: Request | None, stopped: Future[StopAcknowledgement]
    ) -> None:
        """Acknowledge a stop, and record it."""
        if request is not None:
            try:
                request.reply(encode(stopped.result()))
            except Exception:  # the client ended, or the stop failed
                log.exception("cannot acknowledge an emergency stop")
        self._save()
        if self._identity is not None:
            self._identity.audit_trail.record_outcome(asked, None, "done")


def _admit(request: Request, identity: NodeIdentity) -> Identity:
    """Return the sender of a request to stop; only executors require a challenge."""
    if identity.role is Role.EXECUTOR:
        return identity.authenticate(request)
    return identity.authenticate_stop(request.key, request.payload, request.attachment)


@contextmanager
def stop_thread(
    identity: NodeIdentity | None, stop: Stop, save: Callable[[], object], namespace: str
) -> Iterator[StopThread]:
    """Run a thread for emergency stops while the block lasts; see `StopThread` for the arguments.

    Threads switch more often meanwhile: in a flood of requests, the thread of stops waits for dozens of others.
    They share heaps, so that repeated floods do not add up.
    """
    limit_heaps()
    before = sys.getswitchinterval()
    sys.setswitchinterval(min(before, SWITCH_INTERVAL))
    thread = StopThread(identity, stop, save, namespace)
    try:
        yield thread
    finally:
        thread.close()
        sys.setswitchinterval(before)


@asynccontextmanager
async def subscribing_to_stops(
    thread: StopThread, listener: Listener, session: AsyncSession
) -> AsyncIterator[None]:
    """Subscribe to emergency stops while the block lasts.

    At a router, stops have a separate connection: on that of the session, they would wait for earlier messages.

    Args:
        thread: Thread that executes them.
        listener: Listener of the server.
        session: Session of the server.
    """
    async with AsyncExitStack() as stack:
        own = session
        if listener.listen is None:
            own = await stack.enter_async_context(listener.open(None))
        largest = EMERGENCY_STOP.limits.size
        await anyio.to_thread.run_sync(declare_subscriber, own.blocking, thread.key, thread.on_published, largest)
        yield
