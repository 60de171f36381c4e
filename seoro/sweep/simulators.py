"""Simulators that several runs of a sweep have one after the other: starting one takes as long as many a run."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
from anyio.abc import ByteReceiveStream, Process

from seoro.background import background
from seoro.bridges.launch import folder_for_sockets
from seoro.sweep.keeping import kept

OPTION = "--sim="
START_TIMEOUT = 60.0  # [s]


@asynccontextmanager
async def simulator_for(arguments: Sequence[str]) -> AsyncIterator[Sequence[str]]:
    """A simulator for runs that want one of their own, in the block.

    Args:
        arguments: Of `seoro exec`.

    Returns:
        The arguments, with that simulator in the place of one that each run would start. If it cannot be started,
        they stay what they are: the runs themselves say why.
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
    """Wait for the line that a node prints when it serves; without it, its stdout ends."""
    assert process.stdout is not None
    with anyio.move_on_after(START_TIMEOUT):
        async for chunk in process.stdout:
            if b"\n" in chunk:
                return True
    return False


async def _drain(stream: ByteReceiveStream | None) -> None:
    """Read what nobody needs, so that the writer is not held up: what goes wrong, the run is told."""
    assert stream is not None
    async for _ in stream:
        pass
