"""Calls of code that may block, in threads that do not keep the process alive."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

T = TypeVar("T")


async def call_in_thread(function: Callable[[], T]) -> T:
    """Call a function in a daemon thread, which a cancellation abandons."""
    loop = asyncio.get_running_loop()
    done: asyncio.Future[T] = loop.create_future()

    def succeed(result: T) -> None:
        if not done.cancelled():
            done.set_result(result)

    def fail(error: Exception) -> None:
        if not done.cancelled():
            done.set_exception(error)

    def call() -> None:
        with suppress(RuntimeError):  # the event loop may be closed at the end
            try:
                result = function()
            except Exception as error:
                loop.call_soon_threadsafe(fail, error)
            except SystemExit as error:
                loop.call_soon_threadsafe(fail, RuntimeError(f"SystemExit: {error}"))
            else:
                loop.call_soon_threadsafe(succeed, result)

    threading.Thread(target=call, name="seoro action", daemon=True).start()
    return await done
