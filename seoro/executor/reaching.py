"""Being reached: requests are taken, and emergency stops that are published."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Final

import anyio
from anyio.abc import TaskGroup, TaskStatus

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.door import Door
from seoro.bridges.executor.messages import EXECUTOR_VERBS, RECORDS, UNAVAILABLE
from seoro.bridges.executor.sight import LOOK
from seoro.bridges.serving.answering import answer, decoded
from seoro.bridges.serving.emergency import StopLine, hearing_stops
from seoro.bridges.serving.intake import CountedIntake
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire.keys import executor_command
from seoro.bridges.wire.message import Message
from seoro.bridges.wire.proving import CLAIM
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.gate import FOLLOWED, Gate
from seoro.executor.naming import Name

if TYPE_CHECKING:
    from seoro.bridges.lock import Lock

VERBS: Final = (*EXECUTOR_VERBS, CLAIM, LOOK, wire.EMERGENCY_STOP, wire.RELEASE_STOP)
WAITING: Final = Bound(1024, lose="newest")  # requests


class Reached:
    """Where an executor is reached.

    Args:
        name: Of the executor.
        door: Where.
        lock: The keys of the executor; None if it has none.

    Attributes:
        name_lost: Set when it is not reached by its name any more: another has it, who has started before.
    """

    def __init__(self, name: str, door: Door, lock: Lock | None) -> None:
        self._key = executor_command(wire.NAMESPACE, name, "*")
        self._name = Name(name, lock)
        self._door = door
        self._attestor = None if lock is None else lock.answers
        self._had_name = False
        self.name_lost = anyio.Event()

    @property
    def why_it_ends(self) -> str:
        """Why the executor ends, when it does."""
        return self.why_name_lost if self.name_lost.is_set() else "the executor ends"

    @property
    def why_name_lost(self) -> str:
        """Why the name is lost, when it is."""
        return self._name.lost

    @asynccontextmanager
    async def answering(self, gate: Gate, stops: StopLine, tasks: TaskGroup) -> AsyncIterator[None]:
        """Answer requests for as long as the block lasts, and in its end those that came before it.

        Args:
            gate: Carries them out.
            stops: Obeys emergency stops.
            tasks: Where requests are carried out.

        Raises:
            InvalidUse: Another executor has the name.
            SessionError: The endpoint does not work.
        """
        async with background() as duties:
            await duties.start(self._door.attend, partial(self._served, gate, stops, tasks))
            yield

    @asynccontextmanager
    async def _served(
        self, gate: Gate, stops: StopLine, tasks: TaskGroup, session: AsyncSession
    ) -> AsyncIterator[None]:
        async with hearing_stops(stops, self._door, session), background() as duties:
            await duties.start(self._take_requests, gate, stops, tasks, session)
            yield

    async def _take_requests(
        self,
        gate: Gate,
        stops: StopLine,
        tasks: TaskGroup,
        session: AsyncSession,
        *,
        task_status: TaskStatus[None],
    ) -> None:
        """Take requests under the name, for as long as nobody has it who had it before."""
        busy = wire.encode(wire.Refusal(code=UNAVAILABLE, message="the executor is busy: ask again later"))
        if not self._had_name:
            await self._name.wait_until_free(session)
        intake = CountedIntake(VERBS, "executor", UNAVAILABLE, {RECORDS.name: FOLLOWED}, stops.take)
        async with (
            session.answering(self._key, WAITING, busy, intake, self._attestor) as requests,
            session.token(self._name.token),
            background() as duties,
        ):
            duties.start_soon(self._answer, gate, requests, tasks)
            if not self._had_name:
                await self._name.check_first(session)
            self._had_name = True
            task_status.started()
            await self._name.wait_for_elder(session)
        self.name_lost.set()

    async def _answer(self, gate: Gate, requests: Mailbox[Request], tasks: TaskGroup) -> None:
        async for request in requests:
            tasks.start_soon(answer, request, partial(self._carry_out, gate, request), "executor", UNAVAILABLE)
            await asyncio.sleep(0)  # one at a time, so that nothing else waits for as many as have come at once

    async def _carry_out(self, gate: Gate, request: Request, verb: str, payload: bytes) -> Message:
        if verb == CLAIM.name:
            return self._name.claim(decoded(CLAIM, payload))
        if not self._had_name:
            raise RequestRefused(UNAVAILABLE, "the executor starts: ask again later")
        return await gate.carry_out(request, verb, payload)
