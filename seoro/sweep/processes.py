"""Processes of a sweep, each under a keeper (`actions/keeper.py`) that ends it when the sweep ends or dies.

Consecutive runs share a simulator process, since starting one may take as long as a run.
"""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator, Sequence
from contextlib import ExitStack, asynccontextmanager
from pathlib import Path

import anyio
from anyio.abc import ByteReceiveStream, Process

from seoro.actions.processes import SUPERVISOR
from seoro.bridges.launch import folder_for_sockets
from seoro.concurrency.background import background

OPTION = "--sim="
START_TIMEOUT = 60.0  # [s]
ENDING_TIME = 15.0  # [s] for the clean-up of a run when the sweep ends


@asynccontextmanager
async def kept(command: Sequence[str]) -> AsyncIterator[tuple[Process, socket.socket]]:
    """Run a process under a keeper while the block lasts; yield it with the control socket of the keeper."""
    ours, theirs = socket.socketpair()
    with ExitStack() as stack:
        stack.enter_context(ours)
        with theirs:
            keeper = [sys.executable, "-I", "-S", str(SUPERVISOR), str(int(signal.SIGINT)), str(ENDING_TIME)]
            process = await anyio.open_process(
                [*keeper, *command],
                stdin=theirs.fileno(),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
        try:
            yield process, ours
        finally:
            stack.close()  # the keeper then ends the process
            with anyio.CancelScope(shield=True):
                await process.aclose()


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
