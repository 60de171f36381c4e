"""Simulator of a slot of the pool: a node that consecutive runs share, since its start may take as long as a run.

Each run loads the world anew, so that all start from the same state.
"""

from __future__ import annotations

import asyncio
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Final

from seoro.bridges.launch import check_installed, folder_for_sockets
from seoro.errors import BackendError
from seoro.lang.frozen import Value

START_TIMEOUT: Final = 60.0  # [s]
STOP_TIMEOUT: Final = 5.0  # [s]; then it is killed


class Node(Value):
    """Running simulator node.

    Args:
        endpoint: Its Zenoh endpoint.
        process: Its process id.
    """

    endpoint: str
    process: int


@asynccontextmanager
async def simulator_node(name: str) -> AsyncIterator[Node]:
    """Run a simulator node while the block lasts; it ends with this process, too.

    Raises:
        UsageError: The simulator is unknown or not installed.
        BackendError: It did not start.
    """
    check_installed(name)
    with tempfile.TemporaryDirectory(prefix="seoro-", dir=folder_for_sockets()) as folder:
        endpoint = f"unixsock-stream/{Path(folder) / 'hub.sock'}"
        command = [sys.executable, "-m", "sim_nodes", name, "--listen", endpoint, "--node", name]
        process = await asyncio.create_subprocess_exec(
            *command,
            "--die-with-parent",
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        assert process.stdout is not None, "a pipe"
        try:
            async with asyncio.timeout(START_TIMEOUT):
                line = await process.stdout.readline()
            if not line:
                raise BackendError(f"the simulator {name} has ended with status {await process.wait()}")
            yield Node(endpoint, process.pid)
        except TimeoutError:
            raise BackendError(f"the simulator {name} did not start within {START_TIMEOUT:g} s") from None
        finally:
            await _end(process)


async def _end(process: asyncio.subprocess.Process) -> None:
    if process.stdin is not None:
        process.stdin.close()
    try:
        async with asyncio.timeout(STOP_TIMEOUT):
            await process.wait()
    except TimeoutError:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()
