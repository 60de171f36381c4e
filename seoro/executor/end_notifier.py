"""Notifications of the ends of runs, for `seoro serve --notify`."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Final

import anyio
import anyio.to_thread

from seoro.bridges.executor.messages import RunInfo
from seoro.notifications.addresses import Address
from seoro.notifications.delivery import LONGEST, deliver
from seoro.notifications.message import Message

MOST_WAITING: Final = 100

log = logging.getLogger(__name__)


class EndNotifier:
    """Notifies URLs of ended runs, in their order.

    Args:
        executor: Name of the executor.
        addresses: The URLs.
    """

    def __init__(self, executor: str, addresses: Sequence[Address]) -> None:
        self._executor = executor
        self._addresses = addresses
        self._sent, self._waiting = anyio.create_memory_object_stream[Message](MOST_WAITING)
        self._is_done = anyio.Event()

    def __enter__(self) -> EndNotifier:
        return self

    def __exit__(self, *_: object) -> None:
        self._sent.close()
        self._waiting.close()

    def note(self, info: RunInfo) -> None:
        """Queue a notification; if too many wait, log a warning instead."""
        if not self._addresses:
            return
        content = {
            "status": info.state.value,
            "reason": info.reason,
            "file": info.file,
            "executor": self._executor,
            "run": info.run,
            "by": info.by,
            "submitted": info.submitted,
            "started": info.started,
        }
        try:
            self._sent.send_nowait(Message("run", content))
        except anyio.WouldBlock:
            log.warning("notification of run %s dropped: %d wait already", info.run, MOST_WAITING)

    async def work(self) -> None:
        """Deliver notifications until `close`."""
        async for message in self._waiting:
            for problem in await anyio.to_thread.run_sync(
                deliver, self._addresses, message, abandon_on_cancel=True
            ):
                log.warning("notification not delivered: %s", problem)
        self._is_done.set()

    async def close(self) -> None:
        """Deliver the notifications that wait, within a bounded time."""
        self._sent.close()
        with anyio.move_on_after(LONGEST):
            await self._is_done.wait()
