"""Endpoint of an executor: receives requests and published emergency stops."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Final

import anyio
from anyio.abc import TaskGroup, TaskStatus

from seoro.bridges.executor.verbs import EXECUTOR_VERBS
from seoro.bridges.serving.admission import AdmissionLimits
from seoro.bridges.serving.answering import answer
from seoro.bridges.serving.emergency import StopThread, subscribing_to_stops
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire.authentication import CLAIM, UNAVAILABLE
from seoro.bridges.wire.keys import NAMESPACE, executor_command
from seoro.bridges.wire.message import Message
from seoro.bridges.wire.refusal import RequestRefused, read_request
from seoro.concurrency.background import background
from seoro.executor.authorizer import Authorizer
from seoro.executor.name_claim import NameClaim
from seoro.security.network.listener import Listener

if TYPE_CHECKING:
    from seoro.security.network.node_identity import NodeIdentity

WAITING: Final = Bound(1024, drop="newest")  # requests


class ExecutorEndpoint:
    """Receives the requests to an executor.

    Args:
        name: Name of the executor.
        listener: Listener for its sessions.
        identity: Identity of the executor; None without keys.

    Attributes:
        name_lost: Set when an older executor has the same name.
    """

    def __init__(self, name: str, listener: Listener, identity: NodeIdentity | None) -> None:
        self._key = executor_command(NAMESPACE, name, "*")
        self._name = NameClaim(name, identity)
        self._listener = listener
        self._attestor = None if identity is None else identity.answers
        self._had_name = False
        self.name_lost = anyio.Event()

    @property
    def why_it_ends(self) -> str:
        """Reason of the end of the executor, when it ends."""
        return self.why_name_lost if self.name_lost.is_set() else "the executor was stopped"

    @property
    def why_name_lost(self) -> str:
        """Message for the loss of the name."""
        return self._name.lost

    @asynccontextmanager
    async def answering(self, authorizer: Authorizer, stops: StopThread, tasks: TaskGroup) -> AsyncIterator[None]:
        """Answer requests while the block lasts; pending ones are answered at its end.

        Args:
            authorizer: Carries out requests.
            stops: Carries out emergency stops.
            tasks: Task group for requests.

        Raises:
            UsageError: Another executor has the name.
            SessionError: The endpoint cannot be opened.
        """
        async with background() as duties:
            await duties.start(self._listener.serve, partial(self._served, authorizer, stops, tasks))
            yield

    @asynccontextmanager
    async def _served(
        self, authorizer: Authorizer, stops: StopThread, tasks: TaskGroup, session: AsyncSession
    ) -> AsyncIterator[None]:
        async with subscribing_to_stops(stops, self._listener, session), background() as duties:
            await duties.start(self._take_requests, authorizer, stops, tasks, session)
            yield

    async def _take_requests(
        self,
        authorizer: Authorizer,
        stops: StopThread,
        tasks: TaskGroup,
        session: AsyncSession,
        *,
        task_status: TaskStatus[None],
    ) -> None:
        """Receive requests under the name, until an older executor claims it."""
        if not self._had_name:
            await self._name.wait_until_free(session)
        intake = AdmissionLimits(EXECUTOR_VERBS.values(), "executor", UNAVAILABLE, stops.on_request)
        async with (
            session.answering(self._key, WAITING, intake.busy, intake, self._attestor) as requests,
            session.token(self._name.token),
            background() as duties,
        ):
            duties.start_soon(self._answer, authorizer, requests, tasks)
            if not self._had_name:
                await self._name.check_first(session)
            self._had_name = True
            task_status.started()
            await self._name.wait_for_elder(session)
        self.name_lost.set()

    async def _answer(self, authorizer: Authorizer, requests: Mailbox[Request], tasks: TaskGroup) -> None:
        async for request in requests:
            tasks.start_soon(
                answer, request, partial(self._carry_out, authorizer, request), "executor", UNAVAILABLE
            )
            await asyncio.sleep(0)  # one at a time, so that many requests do not block the event loop

    async def _carry_out(
        self, authorizer: Authorizer, request: Request, verb: str, payload: bytes
    ) -> Message | None:
        if verb == CLAIM.name:
            return self._name.claim(read_request(CLAIM, payload))
        if not self._had_name:
            raise RequestRefused(UNAVAILABLE, "the executor is starting: try again later")
        return await authorizer.carry_out(request, verb, payload)
