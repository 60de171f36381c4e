"""Driving an action's coroutine, so that the agenda knows when it waits for the outside world.

An action is ordinary asyncio code. Whatever it awaits surfaces here as the future that its task would wait on:
if it is the agenda's own, the flow is parked already; any other means that the flow is outside until it is done.

A cancellation is thrown into the action once. What it awaits after that, in `finally` blocks and on the way out of
`async with`, is its clean-up: it is driven on like before, within a grace period of the machine's clock.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine, Generator
from contextlib import suppress
from typing import Any, Protocol

from seoro.runtime.agenda import Agenda, Flow
from seoro.runtime.blocking import Meter


class Watch(Protocol):
    """Sees to what a cancelled action does."""

    @property
    def grace(self) -> float:
        """The time for its clean-up [s]."""
        ...

    def cancelled(self) -> None:
        """Called when it is told that it is cancelled, before its clean-up."""
        ...

    def overrun(self) -> None:
        """Called when the clean-up takes longer."""
        ...


class Drive:
    """Awaitable that carries a coroutine through to its end.

    Args:
        coroutine: Of the action.
        flow: In which it runs.
        agenda: Of the run.
        meter: Measures its steps.
        watch: Is told of its cancellation. When its clean-up overruns, it is cancelled once more, and after
            another grace period it is left where it stands.
    """

    __slots__ = ("_agenda", "_coroutine", "_deadline", "_flow", "_meter", "_overruns", "_watch")

    def __init__(
        self,
        coroutine: Coroutine[Any, Any, None],
        flow: Flow,
        agenda: Agenda,
        meter: Meter,
        watch: Watch,
    ) -> None:
        self._coroutine = coroutine
        self._flow = flow
        self._agenda = agenda
        self._meter = meter
        self._watch = watch
        self._deadline: asyncio.TimerHandle | None = None
        self._overruns = 0

    def __await__(self) -> Generator[Any, None, None]:
        error: BaseException | None = None
        self._flow.on_cancel = self._cancelled
        try:
            while True:
                try:
                    awaited = self._resume(error)
                except StopIteration:
                    return
                error = yield from self._await(awaited)
        except BaseException:
            with suppress(RuntimeError):  # a coroutine that is given up may ignore this, too
                self._coroutine.close()
            raise
        finally:
            self._flow.on_cancel = None
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
        """Wait for what the action awaits; returns what is to be raised in it."""
        flow = self._flow
        parked = awaited is not None and awaited is flow.parked
        if not parked:
            self._agenda.leave(flow, awaited)
        error = yield from _passing(awaited)
        if flow.told:
            return self._cancellation(error)
        if parked and error is None:
            return None
        # A cancel scope within the action may cancel it here, too: that reaches the action in its turn, and is
        # not lost when it comes again while the flow waits for that.
        turn = self._agenda.readmit(flow)
        while not turn.done():
            again = yield from _shielded(turn)
            error = error or again
        flow.parked = None
        return self._cancellation(error) if flow.told else error

    def _cancellation(self, error: BaseException | None) -> asyncio.CancelledError:
        """The agenda has cancelled the flow; that goes before what else may have happened in that moment."""
        self._flow.told = False
        return error if isinstance(error, asyncio.CancelledError) else asyncio.CancelledError()

    def _give_up(self) -> None:
        self._overruns += 1
        self._watch.overrun()
        self._agenda.cancel_again(self._flow)
        self._set_deadline()

    def _cancelled(self) -> None:
        """The action is told that it is cancelled; it may see that without coming by here."""
        if self._deadline is None:
            self._set_deadline()
            self._watch.cancelled()

    def _set_deadline(self) -> None:
        self._deadline = asyncio.get_running_loop().call_later(self._watch.grace, self._give_up)


def _passing(awaited: Any) -> Generator[Any, None, BaseException | None]:
    """Wait for what a task would wait for; returns what that raises, such as a cancellation."""
    try:
        yield awaited
    except GeneratorExit:
        raise
    except BaseException as error:
        return error
    return None


def _shielded(future: asyncio.Future[Any]) -> Generator[Any, None, BaseException | None]:
    """Wait for a future, which itself is not cancelled when the wait is."""
    try:
        yield from asyncio.shield(future)
    except asyncio.CancelledError as cancelled:
        return cancelled
    return None
