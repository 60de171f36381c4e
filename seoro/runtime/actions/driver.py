"""Driver of an action's coroutine; it notifies the scheduler when the action waits for the outside world.

An action is ordinary asyncio code. Its awaits surface here as futures. For a future of the scheduler,
the task is parked already; otherwise the task is outside until the future is done.

A cancellation is thrown into the action once. Everything that it awaits after that, in `finally` blocks and exits
of `async with`, is its clean-up: it is driven as before, within a grace period of the machine's clock.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine, Generator
from contextlib import suppress
from typing import Any, Protocol

from seoro.runtime.execution.blocking import Meter
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task


class Watch(Protocol):
    """Callbacks for a cancelled action."""

    @property
    def grace(self) -> float:
        """Time for its clean-up [s]."""

    def cancelled(self) -> None:
        """Called when the cancellation is delivered, before the clean-up."""

    def overrun(self) -> None:
        """Called when the clean-up takes too long."""


class ActionDriver:
    """Awaitable that runs a coroutine to its end.

    Args:
        coroutine: Coroutine of the action.
        task: Its task.
        scheduler: Scheduler of the run.
        meter: Measures its steps.
        watch: Receives the cancellation and overruns. After an overrun the action is cancelled again, and
            abandoned after another grace period.
    """

    __slots__ = ("_coroutine", "_deadline", "_meter", "_overruns", "_scheduler", "_task", "_watch")

    def __init__(
        self, coroutine: Coroutine[Any, Any, None], task: Task, scheduler: Scheduler, meter: Meter, watch: Watch
    ) -> None:
        self._coroutine = coroutine
        self._task = task
        self._scheduler = scheduler
        self._meter = meter
        self._watch = watch
        self._deadline: asyncio.TimerHandle | None = None
        self._overruns = 0

    def __await__(self) -> Generator[Any, None, None]:
        error: BaseException | None = None
        self._task.on_cancel = self._cancelled
        try:
            while True:
                try:
                    awaited = self._resume(error)
                except StopIteration:
                    return
                error = yield from self._await(awaited)
        except BaseException:
            with suppress(RuntimeError):  # an abandoned coroutine may ignore this too
                self._coroutine.close()
            raise
        finally:
            self._task.on_cancel = None
            if self._deadline is not None:
                self._deadline.cancel()

    def _resume(self, error: BaseException | None) -> Any:
        if error is not None and self._overruns > 1:
            raise error
        self._meter.begin()
        try:
            return self._coroutine.send(None) if error is None else self._coroutine.throw(error)
        finally:
            self._meter.end()

    def _await(self, awaited: Any) -> Generator[Any, None, BaseException | None]:
        """Wait for the future that the action awaits; return the exception to raise in the action."""
        task = self._task
        parked = awaited is not None and awaited is task.parked
        if not parked:
            self._scheduler.leave(task, awaited)
        error = yield from _passing(awaited)
        if task.cancel_seen_next:
            return self._cancellation(error)
        if parked and error is None:
            return None
        # A cancel scope within the action may cancel it here, too. The cancellation reaches the action in its
        # turn, and is kept if it is repeated meanwhile.
        turn = self._scheduler.readmit(task)
        while not turn.done():
            again = yield from _shielded(turn)
            error = error or again
        task.parked = None
        return self._cancellation(error) if task.cancel_seen_next else error

    def _cancellation(self, error: BaseException | None) -> asyncio.CancelledError:
        """Return the cancellation by the scheduler, which precedes other exceptions of that moment."""
        self._task.cancel_seen_next = False
        return error if isinstance(error, asyncio.CancelledError) else asyncio.CancelledError()

    def _give_up(self) -> None:
        self._overruns += 1
        self._watch.overrun()
        self._scheduler.deliver_cancel(self._task)
        self._set_deadline()

    def _cancelled(self) -> None:
        """Start the grace period when the cancellation is delivered, possibly without a step here."""
        if self._deadline is None:
            self._set_deadline()
            self._watch.cancelled()

    def _set_deadline(self) -> None:
        self._deadline = asyncio.get_running_loop().call_later(self._watch.grace, self._give_up)


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
