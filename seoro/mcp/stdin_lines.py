"""Lines of stdin, of bounded length. Waiting for them can be cancelled, unlike reading in a pool of threads."""

from __future__ import annotations

import asyncio
import os
import sys
from threading import Thread
from typing import Final

from seoro.errors import UsageError

LONGEST: Final = 4 << 20  # [bytes] of a message
_CHUNK: Final = 1 << 16  # [bytes]


class StdinLines:
    """Asynchronous iterator over the lines of stdin."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._chunks: asyncio.Queue[bytes] = asyncio.Queue(1)
        self._rest = b""
        Thread(target=self._read, daemon=True).start()  # ends with the process, while it waits for input

    def _read(self) -> None:
        descriptor = sys.stdin.fileno()
        chunk = b"?"
        while chunk:
            try:
                chunk = os.read(descriptor, _CHUNK)
            except OSError:
                chunk = b""
            try:
                asyncio.run_coroutine_threadsafe(self._chunks.put(chunk), self._loop).result()
            except (RuntimeError, asyncio.CancelledError):  # the loop has ended
                return

    def __aiter__(self) -> StdinLines:
        return self

    async def __anext__(self) -> str:
        while b"\n" not in self._rest:
            if len(self._rest) > LONGEST:
                raise UsageError(f"a message of the client is longer than {LONGEST >> 20} MiB")
            chunk = await self._chunks.get()
            if not chunk:
                raise StopAsyncIteration
            self._rest += chunk
        line, _, self._rest = self._rest.partition(b"\n")
        return line.decode("utf-8", "replace")
