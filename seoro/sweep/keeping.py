"""Processes of a sweep, under the keeper that programs of scenarios have (`actions/keeper.py`).

Nothing of them is left when the sweep ends, or dies.
"""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import ExitStack, asynccontextmanager

import anyio
from anyio.abc import Process

from seoro.actions.processes import KEEPER

ENDING_TIME = 15.0  # [s] that a run has for its clean-up when the sweep is ended


@asynccontextmanager
async def kept(command: Sequence[str]) -> AsyncIterator[tuple[Process, socket.socket]]:
    """A process under a keeper, and the socket by which that is told to end it; it has ended after the block."""
    ours, theirs = socket.socketpair()
    with ExitStack() as stack:
        stack.enter_context(ours)
        with theirs:
            keeper = [sys.executable, "-I", "-S", str(KEEPER), str(int(signal.SIGINT)), str(ENDING_TIME)]
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
            stack.close()  # then the keeper ends what is left
            with anyio.CancelScope(shield=True):
                await process.aclose()
