"""Debug adapter of a page: a child process `seoro dap`."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from typing import Any, Final

import anyio

from seoro.dap.connection import MAX_BODY, Connection, InvalidMessage, encode

END_TIMEOUT: Final = 10.0  # [s] for the clean-up of the run; then the child is killed


class Adapter:
    """Debug adapter in a child process. Open it with `start_adapter`."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdin is not None and process.stdout is not None, "opened with pipes"
        self._process = process
        self._input = process.stdin
        self._connection = Connection(process.stdout, process.stdin)

    async def send(self, message: Mapping[str, Any]) -> None:
        """Send a request; one to an adapter that has ended is ignored."""
        with suppress(ConnectionError):
            self._input.write(encode(message))
            await self._input.drain()

    async def receive(self) -> dict[str, Any] | None:
        """Return the next answer or event; None when the adapter has ended."""
        try:
            return await self._connection.receive()
        except InvalidMessage:
            return None

    def stop(self) -> None:
        """End the run with its clean-up, and then the adapter."""
        self._input.close()

    async def end(self) -> None:
        """Wait until the adapter has ended; kill it if this takes too long."""
        self.stop()
        with anyio.move_on_after(END_TIMEOUT):
            while await self.receive() is not None:  # so that it can write its last messages
                pass
            await self._process.wait()
        if self._process.returncode is None:
            self._process.kill()
            await self._process.wait()


@asynccontextmanager
async def start_adapter() -> AsyncIterator[Adapter]:
    """Start a debug adapter; it has ended after the block.

    It has a session of its own, so that Ctrl-C in the terminal of the site does not interrupt its clean-up.
    """
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "seoro", "dap"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        limit=MAX_BODY,
        start_new_session=True,
    )
    adapter = Adapter(process)
    try:
        yield adapter
    finally:
        with anyio.CancelScope(shield=True):
            await adapter.end()
