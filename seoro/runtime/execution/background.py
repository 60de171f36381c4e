"""Resources that outlive the action that opens them: a background process, a recording, a connection.

Each is an asynchronous context manager in a task of its own, independent of actions. The end of the run closes
them in reverse order of opening, each within the grace period and its own additional time.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import anyio

T = TypeVar("T")
OPENING = 0.2  # [s] for an opening that is cancelled, so that it can finish


@dataclass(eq=False)
class BackgroundResource(Generic[T]):
    """An open resource.

    Args:
        value: Value of the context manager.
        release: Requests its closing, without waiting.
        closed: Set when it is closed.
    """

    value: T
    release: Callable[[], None]
    closed: anyio.Event

    async def close(self) -> None:
        """Close it, and wait until it is closed."""
        self.release()
        await self.closed.wait()


@dataclass(eq=False)
class _Host:
    """Task of an open resource."""

    manager: AbstractAsyncContextManager[Any]
    opened: asyncio.Future[Any]
    on_closed: Callable[[float, bool], None]
    grace: float
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    released: anyio.Event = field(default_factory=anyio.Event)
    closed: anyio.Event = field(default_factory=anyio.Event)


class BackgroundResources:
    """Background resources of one run.

    Args:
        start: Starts a task of the event loop that ends with the run at the latest.
        grace: Time to close a resource [s].
        failed: Called when a resource raises after it was opened.
    """

    def __init__(
        self,
        start: Callable[[Coroutine[Any, Any, None]], object],
        grace: float,
        failed: Callable[[Exception], None],
    ) -> None:
        self._start = start
        self._grace = grace
        self._failed = failed
        self._hosts: list[_Host] = []

    async def keep(
        self, manager: AbstractAsyncContextManager[T], grace: float, on_closed: Callable[[float, bool], None]
    ) -> BackgroundResource[T]:
        """Open a resource until the run ends, unless it is closed before.

        Args:
            manager: The context manager.
            grace: Additional time for closing, beyond the grace period [s].
            on_closed: Called when the end of the run has closed it, with the time [s] and whether it was too long.
        """
        host = _Host(manager, asyncio.get_running_loop().create_future(), on_closed, self._grace + grace)
        self._hosts.append(host)
        self._start(self._serve(host))
        try:
            value = await asyncio.shield(host.opened)
        except asyncio.CancelledError:
            host.released.set()
            with anyio.move_on_after(OPENING):
                await host.closed.wait()
            if not host.opened.done():  # it may never be open, such as one that waits for an answer
                host.scope.cancel()
            await host.closed.wait()
            raise
        return BackgroundResource(value, host.released.set, host.closed)

    async def _serve(self, host: _Host) -> None:
        try:
            with host.scope:
                async with host.manager as value:
                    host.opened.set_result(value)
                    await host.released.wait()
        except Exception as error:
            if host.opened.done():
                self._failed(error)
            else:
                host.opened.set_exception(error)
                host.opened.exception()  # mark as retrieved: the opening action may have been cancelled
        finally:
            self._hosts.remove(host)
            host.closed.set()

    async def end(self) -> None:
        """Close all resources, the last opened first."""
        for host in reversed(self._hosts.copy()):
            began = time.monotonic()
            host.released.set()
            with anyio.move_on_after(host.grace) as limit:
                await host.closed.wait()
            if limit.cancelled_caught:
                host.scope.cancel()
                await host.closed.wait()
            host.on_closed(time.monotonic() - began, limit.cancelled_caught)
