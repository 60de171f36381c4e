"""Blocking actions: plain functions, each called in a thread of its own while the event loop continues.

The action's own task stays in charge. Each access of the thread to the run (time, log, sleep) is a request that
the task carries out in its turn. Blocking actions are therefore stepped in the same order as others, and virtual
time stands still while the thread computes and moves while it sleeps.

A thread cannot be killed. When its action is cancelled, its sleep ends and `check_cancelled` raises. If it does
not return within the grace period, it is abandoned; it is a daemon thread, so that the process can exit.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from concurrent.futures import CancelledError as NoAnswer
from concurrent.futures import Future
from contextvars import copy_context
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from seoro.runtime.actions.context import ActionContext
    from seoro.runtime.values.values import Variable

T = TypeVar("T")


@dataclass(eq=False)
class _Request:
    """A request of the thread to the action's task.

    Args:
        serve: Carries out the request in the task.
        lasts: Whether it takes time; it is then skipped if the action has been cancelled.
        answer: Receives the result.
    """

    serve: Callable[[ActionContext], Awaitable[Any]]
    lasts: bool = False
    answer: Future[Any] = field(default_factory=Future)


class _Exchange:
    """Queue of requests from one thread to the action's task.

    Args:
        loop: Event loop of the task.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._requests: asyncio.Queue[_Request] = asyncio.Queue()
        self.cancelled = threading.Event()
        self.is_closed = False

    # -------------------------------------------------------- in the thread

    def post(self, request: _Request) -> None:
        """Add a request; it is cancelled after `close`."""
        if self.is_closed:
            request.answer.cancel()
            return
        try:
            self._loop.call_soon_threadsafe(self._arrive, request)
        except RuntimeError:  # the loop was closed at this moment
            request.answer.cancel()

    def ask(self, request: _Request) -> Any:
        """Add a request, and wait for its answer."""
        self.post(request)
        try:
            return request.answer.result()
        except NoAnswer:
            raise asyncio.CancelledError from None

    # -------------------------------------------------------- in the task

    def _arrive(self, request: _Request) -> None:
        if self.is_closed:
            request.answer.cancel()
        else:
            self._requests.put_nowait(request)

    async def take(self) -> _Request:
        """Wait for the next request, and remove it."""
        return await self._requests.get()

    def close(self) -> None:
        """Cancel all requests: the action is over, even if the thread is not."""
        self.cancelled.set()
        self.is_closed = True
        while not self._requests.empty():
            self._requests.get_nowait().answer.cancel()


class ThreadContext:
    """The run as seen by one invocation of a blocking action from its thread.

    Time is the run's clock: use `sleep` and `now` instead of those of `time`.
    """

    def __init__(self, exchange: _Exchange) -> None:
        self._exchange = exchange

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""

        async def read(ctx: ActionContext) -> float:
            return ctx.now

        return float(self._exchange.ask(_Request(read)))

    @property
    def cancelled(self) -> bool:
        """Whether the action has been cancelled; clean up and return within the grace period."""
        return self._exchange.cancelled.is_set()

    def check_cancelled(self) -> None:
        """Raise if the action has been cancelled.

        Raises:
            asyncio.CancelledError: The action has been cancelled. Clean up in `finally`, without catching this.
        """
        if self.cancelled:
            raise asyncio.CancelledError

    def log(self, message: str, level: str = "info") -> None:
        """Write a message into the trace; levels are `debug`, `info`, `warning` and `error`."""

        async def write(ctx: ActionContext) -> None:
            ctx.log(message, level)

        self._exchange.post(_Request(write))

    def update(self, variable: Variable[T], change: Callable[[T], T]) -> None:
        """Change a variable; see `ActionContext.update`."""

        async def write(ctx: ActionContext) -> None:
            ctx.update(variable, change)

        self._exchange.post(_Request(write))

    def sleep(self, duration: float) -> None:
        """Wait for a duration [s] of the run's clock.

        Raises:
            asyncio.CancelledError: The action was cancelled before or during the sleep.
        """

        async def wait(ctx: ActionContext) -> None:
            await ctx.sleep(duration)

        self._exchange.ask(_Request(wait, lasts=True))


async def run_in_thread(ctx: ActionContext, function: Callable[[ThreadContext], object]) -> None:
    """Call a function in a thread, and serve its requests until it returns.

    Args:
        ctx: Context of the action whose task this is.
        function: The function; called with its context.
    """
    exchange = _Exchange(asyncio.get_running_loop())
    over = Future[None]()
    call = partial(copy_context().run, _call, function, exchange, over)
    thread = threading.Thread(target=call, name=f"seoro action {ctx.name}", daemon=True)
    thread.start()
    ctx.thread = thread
    cancelled: asyncio.CancelledError | None = None
    try:
        while not over.done():
            try:
                request = await exchange.take()
                if request.lasts and exchange.cancelled.is_set():
                    request.answer.cancel()
                else:
                    await _serve(request, ctx)
            except asyncio.CancelledError as error:
                if cancelled is not None:
                    raise  # its grace period is over
                cancelled = error
                exchange.cancelled.set()
    finally:
        exchange.close()
    thread.join()  # its function has returned
    raised = over.exception()
    if raised is not None and not (cancelled is not None and isinstance(raised, asyncio.CancelledError)):
        raise raised
    if cancelled is not None:
        raise cancelled


def _call(function: Callable[[ThreadContext], object], exchange: _Exchange, over: Future[None]) -> None:
    """Run the function in the thread."""
    raised: BaseException | None = None
    try:
        function(ThreadContext(exchange))
    except BaseException as error:  # passed to the action's task
        raised = error

    async def end(ctx: ActionContext) -> None:
        if raised is None:
            over.set_result(None)
        else:
            over.set_exception(raised)

    exchange.post(_Request(end))


async def _serve(request: _Request, ctx: ActionContext) -> None:
    try:
        answer = await request.serve(ctx)
    except asyncio.CancelledError:
        request.answer.cancel()
        raise
    except Exception as error:
        request.answer.set_exception(error)
    else:
        request.answer.set_result(answer)
