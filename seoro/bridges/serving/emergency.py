"""The way of emergency stops: a thread that does nothing else, and at a router a connection of its own.

A stop is published, for those, too, who are not known to the sender, and sent as a request. It takes effect before
anything is answered or written down.
"""

from __future__ import annotations

import logging
import queue
import sys
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import Future
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final, TypeAlias

import anyio.to_thread

from seoro.bridges.door import Door
from seoro.bridges.ledger import Asked
from seoro.bridges.serving.answering import refuse
from seoro.bridges.serving.heaps import limit_heaps
from seoro.bridges.session import AsyncSession, Request, declare_subscriber
from seoro.bridges.wire.keys import emergency_key
from seoro.bridges.wire.lab import EMERGENCY_STOP, EmergencyStop, EmergencyStopped
from seoro.bridges.wire.message import WireError, encode
from seoro.bridges.wire.proving import DENIED, STALE
from seoro.bridges.wire.refusal import RequestRefused
from seoro.keys.roles import MOVING, Role

if TYPE_CHECKING:
    from seoro.bridges.lock import Lock
    from seoro.keys.certificates import Identity

TURN: Final = 5e-4  # [s] for which one thread of Python may keep the others waiting; by default, it is 5 ms
MOST: Final = 256  # stops that wait to be looked at, of which one would do
STOP: Final = EMERGENCY_STOP.name

Stop: TypeAlias = Callable[[EmergencyStop], "Future[EmergencyStopped]"]
"""Stops robots before it returns, whatever other threads do; the result is there when all have been told.

It raises `RequestRefused` if it has none of the named robots.
"""

log = logging.getLogger(__name__)


class StopLine:
    """Obeys emergency stops on a thread of its own. Made by `stop_line`.

    Args:
        lock: Keys of the executor or the node; None if it has none, and obeys everybody who reaches it.
        stop: Stops everything.
        keep: Called afterwards, to write down that it is stopped.
        namespace: Of the executor or the node.
    """

    def __init__(self, lock: Lock | None, stop: Stop, keep: Callable[[], object], namespace: str) -> None:
        self.key = emergency_key(namespace)
        self._lock = lock
        self._stop = stop
        self._keep = keep
        self._jobs: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="emergency stops", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread, after what it has been given."""
        self._jobs.put(None)
        self._thread.join()

    def hear(self, payload: bytes, seal: bytes) -> None:
        """Take a stop that was published; from any thread."""
        if self._jobs.qsize() < MOST:
            self._jobs.put(partial(self._obey, payload, lambda lock: lock.admit_urgent(self.key, payload, seal)))

    def take(self, request: Request) -> None:
        """Take a stop that was asked for; from any thread."""
        self._jobs.put(lambda: self._obey(request.payload, partial(_admit, request), request))

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                job()
            except Exception:
                log.exception("fault in an emergency stop")

    def _obey(self, payload: bytes, admit: Callable[[Lock], Identity], request: Request | None = None) -> None:
        try:
            asked = self._admitted(payload, admit)
        except RequestRefused as refused:
            if request is not None:
                refuse(request, refused.code, refused.message)
            return
        try:
            stop = EMERGENCY_STOP.read(payload)
        except WireError:
            stop = EmergencyStop(by="somebody whose message cannot be read")
        try:
            stopped = self._stop(stop)
        except RequestRefused as refused:
            if request is not None:  # one that was published is for those who have these robots
                refuse(request, refused.code, refused.message)
                self._refuse(asked, refused)
            return
        stopped.add_done_callback(lambda done: self._jobs.put(partial(self._finish, asked, request, done)))

    def _admitted(self, payload: bytes, admit: Callable[[Lock], Identity]) -> Asked:
        """Find out who wants to stop everything.

        Raises:
            RequestRefused: Nobody who may.
        """
        asked = Asked(None, STOP, payload)
        if self._lock is None:
            return asked
        try:
            asked = replace(asked, who=(who := admit(self._lock)))
            if who.role not in MOVING:
                raise RequestRefused(DENIED, f"{who} may not ask for `{STOP}`, which is for one who is operator")
        except RequestRefused as refused:
            if refused.code != STALE:
                self._refuse(asked, refused)
            raise
        return asked

    def _refuse(self, asked: Asked, refused: RequestRefused) -> None:
        if self._lock is not None:
            self._lock.ledger.refuse(asked, refused.message)

    def _finish(self, asked: Asked, request: Request | None, stopped: Future[EmergencyStopped]) -> None:
        """Acknowledge a stop, and write it down."""
        if request is not None:
            try:
                request.reply(encode(stopped.result()))
            except Exception:  # whoever asked is gone, or the stop has failed
                log.exception("cannot acknowledge an emergency stop")
        self._keep()
        if self._lock is not None:
            self._lock.ledger.conclude(asked, None, "done")


def _admit(request: Request, lock: Lock) -> Identity:
    """Find out who has asked; executors challenge first, nodes are asked at once."""
    if lock.role is Role.EXECUTOR:
        return lock.admit(request)
    return lock.admit_urgent(request.key, request.payload, request.attachment)


@contextmanager
def stop_line(lock: Lock | None, stop: Stop, keep: Callable[[], object], namespace: str) -> Iterator[StopLine]:
    """Have a way for emergency stops for as long as the block lasts; see `StopLine` for the arguments.

    Threads take turns often meanwhile: in a flood of requests, the thread of stops waits for some dozen others.
    They share heaps: repeated floods do not add up.
    """
    limit_heaps()
    before = sys.getswitchinterval()
    sys.setswitchinterval(min(before, TURN))
    line = StopLine(lock, stop, keep, namespace)
    try:
        yield line
    finally:
        line.close()
        sys.setswitchinterval(before)


@asynccontextmanager
async def hearing_stops(line: StopLine, door: Door, session: AsyncSession) -> AsyncIterator[None]:
    """Hear emergency stops for as long as the block lasts.

    At a router they come over a connection of their own: on that of the session, they would wait for whatever
    comes before them.

    Args:
        line: Obeys them.
        door: Where the executor or the node is reached.
        session: At which it is.
    """
    async with AsyncExitStack() as stack:
        own = session
        if door.listen is None:
            own = await stack.enter_async_context(door.open(None))
        largest = EMERGENCY_STOP.limits.size
        await anyio.to_thread.run_sync(declare_subscriber, own.blocking, line.key, line.hear, largest)
        yield
