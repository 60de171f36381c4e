"""Processes of a sweep, each under a keeper (`actions/keeper.py`) that ends it when the sweep ends or dies."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import ExitStack, asynccontextmanager

import anyio
from anyio.abc import Process

from seoro.actions.processes import SUPERVISOR

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
