"""Waits of a task for the outside world, of which the scheduler is notified."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Generator
from typing import Any, Generic, TypeVar

from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task

T = TypeVar("T")


def wait_outside(scheduler: Scheduler, task: Task, awaited: Any) -> Generator[Any, None, BaseException | None]:
    """Wait for a future that the code of a task awaits; return the exception to raise in this code."""
    parked = awaited is not None and awaited is task.parked
    if not parked:
        scheduler.leave(task, awaited)
    error = yield from _passing(awaited)
    if task.cancel_seen_next:
        return _cancellation(task, error)
    if parked and error is None:
        return None
    # A cancel scope within the code may cancel it here, too. The cancellation reaches the code in its turn, and is
    # kept if it is repeated meanwhile.
    turn = scheduler.readmit(task)
    while not turn.done():
        again = yield from _shielded(turn)
        error = error or again
    task.parked = None
    return _cancellation(task, error) if task.cancel_seen_next else error


class Asking(Generic[T]):
    """Awaitable that awaits a request to a backend, for code that no `ActionDriver` drives.

    Args:
        scheduler: Scheduler of the run.
        task: Task that awaits it.
        request: The request; it takes no time of the run's clock.
    """

    def __init__(self, scheduler: Scheduler, task: Task, request: Awaitable[T]) -> None:
        self._scheduler = scheduler
        self._task = task
        self._request = request

    def __await__(self) -> Generator[Any, None, T]:
        steps = _awaiting(self._request)
        error: BaseException | None = None
        self._task.awaits_answer = True
        try:
            while True:
                try:
                    awaited = steps.send(None) if error is None else steps.throw(error)
                except StopIteration as returned:
                    result: T = returned.value
                    return result
                error = yield from wait_outside(self._scheduler, self._task, awaited)
        finally:
            self._task.awaits_answer = False
            steps.close()


async def _awaiting(request: Awaitable[T]) -> T:
    return await request


def _cancellation(task: Task, error: BaseException | None) -> asyncio.CancelledError:
    """Return the cancellation by the scheduler, which precedes other exceptions of that moment."""
    task.cancel_seen_next = False
    return error if isinstance(error, asyncio.CancelledError) else asyncio.CancelledError()


def _passing(awaited: Any) -> Generator[Any, None, BaseException | None]:
    """Await a future like a task; return its exception, such as a cancellation."""
    try:
        yield awaited
    except GeneratorExit:
        raise
    except BaseException as error:
        return error
    return None


def _shielded(future: asyncio.Future[Any]) -> Generator[Any, None, BaseException | None]:
    """Await a future without cancelling it when the wait is cancelled."""
    try:
        yield from asyncio.shield(future)
    except asyncio.CancelledError as cancelled:
        return cancelled
    return None
