"""Simulator of a slot of the pool: a node that consecutive runs share, since its start may take as long as a run.

Each run loads the world anew, so that all start from the same state.
"""

from __future__ import annotations

import asyncio
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Final, Protocol

from seoro.embed.options import ROS_SIMULATOR
from seoro.errors import BackendError
from seoro.lang.frozen import Value

STOP_TIMEOUT: Final = 5.0  # [s]; then it is killed
STDERR_TIMEOUT: Final = 0.5  # [s] to read the last lines of an ended process
STDERR_LINES: Final = 20  # kept for messages
_BLOCK: Final = 1 << 16  # [bytes]


class Node(Value):
    """Running simulator node.

    Args:
        endpoint: Its Zenoh endpoint.
        process: Its process.
        errors: Last lines of its stderr so far.
    """

    endpoint: str
    process: asyncio.subprocess.Process
    errors: deque[str]


class Named(Protocol):
    """Simulator of a run, as in options and in bundles."""

    @property
    def name(self) -> str | None:
        """Its name; None for a running one."""


def own_simulator(simulator: Named | None) -> str | None:
    """Return the name of the simulator that each slot starts; None if runs share one, or need none."""
    return None if simulator is None or simulator.name == ROS_SIMULATOR else simulator.name


@asynccontextmanager
async def simulator_node(name: str) -> AsyncIterator[Node]:
    """Run a simulator node while the block lasts; it ends with this process, too.

    Raises:
        UsageError: The simulator is unknown or not installed.
        BackendError: It did not start.
    """
    from seoro.bridges.launch import (  # noqa: PLC0415 - for campaigns with a simulator only
        START_TIMEOUT,
        check_installed,
        folder_for_sockets,
    )

    check_installed(name)
    with tempfile.TemporaryDirectory(prefix="seoro-", dir=folder_for_sockets()) as folder:
        endpoint = f"unixsock-stream/{Path(folder) / 'hub.sock'}"
        command = [sys.executable, "-m", "sim_nodes", name, "--listen", endpoint, "--node", name]
        process = await asyncio.create_subprocess_exec(
            *command,
            "--die-with-parent",
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        assert process.stdout is not None and process.stderr is not None, "pipes"
        errors: deque[str] = deque(maxlen=STDERR_LINES)
        reading = asyncio.create_task(_keep_last_lines(process.stderr, errors))
        try:
            async with asyncio.timeout(START_TIMEOUT):
                line = await process.stdout.readline()
            if not line:
                await asyncio.wait([reading], timeout=STDERR_TIMEOUT)  # a child process may keep it open
                reason = f": {errors[-1]}" if errors else ""
                raise BackendError(
                    f"the simulator {name} did not start: it ended with status {await process.wait()}{reason}"
                )
            yield Node(endpoint, process, errors)
        except TimeoutError:
            raise BackendError(f"the simulator {name} did not start within {START_TIMEOUT:g} s") from None
        finally:
            await _end(process)
            reading.cancel()


async def _keep_last_lines(stderr: asyncio.StreamReader, errors: deque[str]) -> None:
    rest = b""
    while data := await stderr.read(_BLOCK):
        *whole, rest = (rest + data).split(b"\n")
        errors.extend(line.decode(errors="replace") for line in whole if line.strip())
        rest = rest[-_BLOCK:]


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
