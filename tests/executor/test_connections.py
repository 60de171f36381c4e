"""Connections to the processes of runs, on both event loops."""

from __future__ import annotations

import asyncio
import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
import uvloop

from seoro.concurrency.forks.using import socket_reader


@pytest.mark.parametrize("make_loop", [asyncio.new_event_loop, uvloop.new_event_loop])
def test_closing_a_connection_closes_no_reused_file(
    make_loop: Callable[[], asyncio.AbstractEventLoop], tmp_path: Path
) -> None:
    ours, theirs = socket.socketpair()
    number = ours.fileno()

    async def read_to_the_end() -> bytes:
        reader = await socket_reader(ours)
        theirs.sendall(b"all of it")
        theirs.close()
        found = await reader.read()
        while ours.fileno() != -1:
            await asyncio.sleep(0)
        return found

    with asyncio.Runner(loop_factory=make_loop) as runner:
        assert runner.run(read_to_the_end()) == b"all of it"
        other = os.open(tmp_path, os.O_RDONLY)
        if other != number:  # then it has the number, as a file that a thread has opened may have
            os.dup2(other, number)
            os.close(other)
        runner.run(asyncio.sleep(0))
        os.fstat(number)
        os.close(number)
