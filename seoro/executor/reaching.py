"""Being reached: requests are taken, and emergency stops that are published."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import Final

from anyio.abc import TaskGroup

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.door import Door
from seoro.bridges.executor.messages import UNAVAILABLE
from seoro.bridges.serving.answering import answer
from seoro.bridges.serving.emergency import emergencies
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire.keys import executor_command
from seoro.executor.emergency import Emergency
from seoro.executor.gate import Gate
from seoro.executor.naming import announced, await_name

WAITING: Final = Bound(1024, lose="newest")  # requests


class Reached:
    """Where an executor is reached.

    Args:
        name: Of the executor.
        door: Where.
    """

    def __init__(self, name: str, door: Door) -> None:
        self._name = name
        self._door = door
        self._had_name = False

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
            await duties.start(self._door.attend, partial(self._served, gate, emergency, tasks))
            yield

    @asynccontextmanager
    async def _served(
        self, gate: Gate, emergency: Emergency, tasks: TaskGroup, session: AsyncSession
    ) -> AsyncIterator[None]:
        busy = wire.encode(wire.Refusal(code=UNAVAILABLE, message="the executor is busy: ask again later"))
        if not self._had_name:
            await await_name(session, self._name)
            self._had_name = True
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
