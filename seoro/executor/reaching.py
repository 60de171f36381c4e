"""Being reached: a session at which requests are taken, opened anew when somebody's keys are revoked.

Zenoh has the list of those whom it lets pass when a session opens, and keeps it. So a hub is closed and opened for
each new list: sessions of others come back by themselves, but those that are on it get nothing any more. What
clients had asked for meanwhile they ask for again.
"""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Final

import anyio
from anyio.abc import TaskGroup, TaskStatus

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.executor.messages import UNAVAILABLE
from seoro.bridges.secured import security_of
from seoro.bridges.serving.answering import answer
from seoro.bridges.serving.emergency import emergencies
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request, SessionError, open_session
from seoro.bridges.wire.keys import executor_command
from seoro.executor.emergency import Emergency
from seoro.executor.gate import Gate
from seoro.executor.naming import announced, await_name

if TYPE_CHECKING:
    from seoro.bridges.revoked import Revoked
    from seoro.keys.certificates import Seat
    from seoro.keys.folder import Keys

WAITING: Final = Bound(1024, lose="newest")  # requests
PAUSE: Final = 0.2  # [s] before an endpoint that does not open again is tried once more

log = logging.getLogger(__name__)


class Reached:
    """Where an executor is reached.

    Args:
        name: Of the executor.
        listen: Endpoint at which it listens.
        connect: Endpoint of a hub to connect to, instead.
        keys: Its keys.
        revoked: Who is revoked, if there are keys.
    """

    def __init__(
        self,
        name: str,
        listen: str | None,
        connect: str | None,
        keys: Keys | None,
        revoked: Revoked | None,
    ) -> None:
        self._name = name
        self._listen = listen
        self._connect = connect
        self._keys = keys
        self._revoked = revoked

    @asynccontextmanager
    async def answering(self, gate: Gate, emergency: Emergency, tasks: TaskGroup) -> AsyncIterator[None]:
        """Answer requests for as long as the block lasts, and in its end those that came before it.

        Args:
            gate: Carries them out.
            emergency: Is told of emergency stops that are published.
            tasks: Where requests are carried out.

        Raises:
            InvalidUse: Another executor has the name.
            SessionError: The endpoint does not work.
        """
        async with background() as duties:
            await duties.start(self._work, gate, emergency, tasks)
            if self._revoked is not None:
                duties.start_soon(self._revoked.follow)
            yield

    async def _work(
        self, gate: Gate, emergency: Emergency, tasks: TaskGroup, *, task_status: TaskStatus[None]
    ) -> None:
        is_open = False
        while True:
            known: frozenset[Seat] = frozenset() if self._revoked is None else self._revoked.current().seats
            try:
                async with self._session(known) as session:
                    if not is_open:
                        await await_name(session, self._name)
                    async with self._served(session, gate, emergency, tasks):
                        if not is_open:
                            task_status.started()
                        is_open = True
                        await self._until_closed(known)
            except SessionError as error:
                if not is_open:
                    raise
                log.error("cannot be reached: %s; trying again", error)
                await anyio.sleep(PAUSE)

    def _session(self, known: frozenset[Seat]) -> AbstractAsyncContextManager[AsyncSession]:
        endpoint = self._listen or self._connect or ""
        security = security_of(endpoint, self._keys, listens=self._listen is not None, revoked=known)
        return open_session(listen=self._listen, connect=self._connect, security=security)

    async def _until_closed(self, known: frozenset[Seat]) -> None:
        """Wait until the session has to be opened anew; one that is no hub lets nobody pass by itself."""
        if self._revoked is None or self._listen is None:
            await anyio.sleep_forever()
        else:
            await self._revoked.wait_for_change(known)

    @asynccontextmanager
    async def _served(
        self, session: AsyncSession, gate: Gate, emergency: Emergency, tasks: TaskGroup
    ) -> AsyncIterator[None]:
        busy = wire.encode(wire.Refusal(code=UNAVAILABLE, message="the executor is busy: ask again later"))
        async with (
            emergencies(session, wire.NAMESPACE) as heard,
            session.answering(executor_command(wire.NAMESPACE, self._name, "*"), WAITING, busy) as requests,
            announced(session, self._name),
            background() as duties,
        ):
            duties.start_soon(_answer, gate, requests, tasks)
            duties.start_soon(emergency.obey, heard)
            yield


async def _answer(gate: Gate, requests: Mailbox[Request], tasks: TaskGroup) -> None:
    async for request in requests:
        tasks.start_soon(answer, request, partial(gate.carry_out, request), "executor", UNAVAILABLE)
