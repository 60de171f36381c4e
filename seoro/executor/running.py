"""An executor, put together: it listens, answers, runs what is queued, and forgets what is old."""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import anyio
from anyio.abc import TaskGroup

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.executor.messages import UNAVAILABLE
from seoro.bridges.serving.answering import answer
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request, open_session
from seoro.bridges.wire.keys import executor_command
from seoro.executor.naming import announced, await_name
from seoro.executor.policy import check_permissions
from seoro.executor.queue import Queue
from seoro.executor.serving import Server, days_ago
from seoro.executor.store import open_store
from seoro.executor.workers import open_pool

WAITING: Final = Bound(1024, lose="newest")  # requests
LAST_ANSWERS: Final = 0.3  # [s] in which watchers hear of the end of runs that the end of the executor has stopped
FORGET_PERIOD: Final = 600.0  # [s]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ExecutorOptions:
    """How an executor works.

    Args:
        name: Of the executor, for its clients.
        folder: Where it keeps runs.
        listen: Endpoint at which it listens, as the hub of its clients.
        connect: Endpoint of a hub to connect to, instead.
        jobs: How many runs go on at a time.
        keep: Days for which runs that are over are kept.
        allowed: What scenarios may do that they else may not.
    """

    name: str
    folder: Path
    listen: str | None = None
    connect: str | None = None
    jobs: int = 1
    keep: float = 30.0
    allowed: frozenset[str] = frozenset()


@asynccontextmanager
async def executing(options: ExecutorOptions) -> AsyncIterator[int]:
    """Be an executor for as long as the block lasts; yields how many runs an earlier start has lost.

    Raises:
        InvalidUse: The folder cannot be used, or another executor has the name.
        SessionError: The endpoint does not work.
    """
    check_permissions(options.allowed)
    with open_store(options.folder) as store:
        lost = await store.give_up_running()
        await store.sweep()
        async with (
            open_session(listen=options.listen, connect=options.connect) as session,
            open_pool() as pool,
            background() as tasks,
        ):
            await await_name(session, options.name)
            queue = Queue(store, pool, tasks, options.jobs, options.allowed)
            for run in await store.queued():
                queue.add(await store.info(run), await store.submission(run))
            server = Server(store, queue, options.jobs, tuple(sorted(options.allowed)))
            async with _serving(session, options, server, tasks), background() as duties:
                duties.start_soon(queue.work)
                duties.start_soon(queue.stop_lonely)
                duties.start_soon(_forget, server, options.keep)
                try:
                    yield lost
                finally:
                    with anyio.CancelScope(shield=True):
                        if await queue.close():
                            await anyio.sleep(LAST_ANSWERS)


@asynccontextmanager
async def _serving(
    session: AsyncSession, options: ExecutorOptions, server: Server, tasks: TaskGroup
) -> AsyncIterator[None]:
    """Answer requests for as long as the block lasts, and in its end those that came before it."""
    busy = wire.encode(wire.Refusal(code=UNAVAILABLE, message="the executor is busy: ask again later"))
    name = options.name
    async with (
        session.answering(executor_command(wire.NAMESPACE, name, "*"), WAITING, busy) as requests,
        announced(session, name),
        background() as duties,
    ):
        duties.start_soon(_answer, server, requests, tasks)
        yield


async def _answer(server: Server, requests: Mailbox[Request], tasks: TaskGroup) -> None:
    async for request in requests:
        tasks.start_soon(answer, request, server.carry_out, "executor", UNAVAILABLE)


async def _forget(server: Server, keep: float) -> None:
    while True:
        try:
            await server.forget(days_ago(keep))
        except (OSError, sqlite3.Error):  # to be tried again later
            log.exception("cannot forget what is old")
        await anyio.sleep(FORGET_PERIOD)
