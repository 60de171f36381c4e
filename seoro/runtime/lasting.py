"""What outlives the action that opens it, but not the run: a process that goes on, a recording, a connection.

Each is an asynchronous context manager, entered and left in a task of its own, since actions come and go. At the
end of the run they are closed in reverse order of their opening, each within the grace period and what it asks for
beyond that.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import anyio
from anyio.abc import TaskGroup

T = TypeVar("T")
OPENING = 0.2  # [s] that opening has left when nobody wants it any more: then what has begun ends as it should


@dataclass(eq=False)
class Kept(Generic[T]):
    """Something that is open.

    Args:
        value: What the context manager gave.
        release: Lets it be closed, without waiting for that.
        closed: Set when it is closed.
    """

    value: T
    release: Callable[[], None]
    closed: anyio.Event

    async def close(self) -> None:
        """Close it now, and wait until it is closed."""
        self.release()
        await self.closed.wait()


@dataclass(eq=False)
class _Host:
    """The task in which something is open."""

    manager: AbstractAsyncContextManager[Any]
    opened: asyncio.Future[Any]
    told: Callable[[float, bool], None]
    grace: float
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    released: anyio.Event = field(default_factory=anyio.Event)
    closed: anyio.Event = field(default_factory=anyio.Event)


class Lasting:
    """Everything of one run that lasts.

    Args:
        group: Of the run.
        grace: Time to close one [s].
        failed: Called when one raises after it was opened.
    """

    def __init__(self, group: TaskGroup, grace: float, failed: Callable[[Exception], None]) -> None:
        self._group = group
        self._grace = grace
        self._failed = failed
        self._hosts: list[_Host] = []

    async def keep(
        self, manager: AbstractAsyncContextManager[T], grace: float, told: Callable[[float, bool], None]
    ) -> Kept[T]:
        """Open something that stays open until the run ends, unless it is closed before.

        Args:
            manager: Opens and closes it.
            grace: How much longer than the grace period closing it may take [s].
            told: Called when the end of the run has closed it: how long that took [s], whether it was too long.
        """
        host = _Host(manager, asyncio.get_running_loop().create_future(), told, self._grace + grace)
        self._hosts.append(host)
        self._group.start_soon(self._serve, host)
        try:
            value = await asyncio.shield(host.opened)
        except asyncio.CancelledError:
            host.released.set()
            await self._give_up(host)
            raise
        return Kept(value, host.released.set, host.closed)

    @staticmethod
    async def _give_up(host: _Host) -> None:
        """Have something closed that may never be open, such as what waits for somebody to answer."""
        with anyio.move_on_after(OPENING):
            await host.closed.wait()
        if not host.opened.done():
            host.scope.cancel()
        await host.closed.wait()

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
                host.opened.exception()  # whoever opens it may have been cancelled
        finally:
            self._hosts.remove(host)
            host.closed.set()

    async def end(self) -> None:
        """Close what is open, the last that was opened first."""
        for host in reversed(self._hosts.copy()):
            began = time.monotonic()
            host.released.set()
            with anyio.move_on_after(host.grace) as limit:
                await host.closed.wait()
            if limit.cancelled_caught:
                host.scope.cancel()
                await host.closed.wait()
            host.told(time.monotonic() - began, limit.cancelled_caught)
