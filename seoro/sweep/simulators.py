"""Simulators shared by consecutive runs of a sweep, since starting one may take as long as a run."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
from anyio.abc import ByteReceiveStream, Process

from seoro.bridges.launch import folder_for_sockets
from seoro.concurrency.background import background
from seoro.sweep.keeping import kept

OPTION = "--sim="
START_TIMEOUT = 60.0  # [s]


@asynccontextmanager
async def simulator_for(arguments: Sequence[str]) -> AsyncIterator[Sequence[str]]:
    """Start a simulator for consecutive runs while the block lasts.

    Args:
        arguments: Arguments of `seoro exec`.

    Returns:
        The arguments, with `--connect` to this simulator instead of `--sim`. They are unchanged if it cannot be
        started; the runs then report the reason.
    """
    name = next((each.removeprefix(OPTION) for each in arguments if each.startswith(OPTION)), None)
    if name is None:
        yield arguments
        return
    with tempfile.TemporaryDirectory(prefix="seoro-", dir=folder_for_sockets()) as folder:
        endpoint = f"unixsock-stream/{Path(folder) / 'hub.sock'}"
        command = [sys.executable, "-m", "sim_nodes", name, "--listen", endpoint, "--node", name]
        async with kept(command) as (process, _), background() as group:
            group.start_soon(_drain, process.stderr)
            if await _has_started(process):
                yield [f"--connect={endpoint}" if each.startswith(OPTION) else each for each in arguments]
            else:
                yield arguments


async def _has_started(process: Process) -> bool:
    """Wait for the line that a node prints when it is ready; return whether it came."""
    assert process.stdout is not None
    with anyio.move_on_after(START_TIMEOUT):
        async for chunk in process.stdout:
            if b"\n" in chunk:
                return True
    return False


async def _drain(stream: ByteReceiveStream | None) -> None:
    """Discard the output of a process, so that it does not block; the run reports errors."""
    assert stream is not None
    async for _ in stream:
        pass
