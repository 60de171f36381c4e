"""The executor of a site: a child process, for runs of this machine."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import anyio
from anyio.abc import Process
from anyio.streams.text import TextReceiveStream

from seoro.actions.processes import RUNNING_PROGRAMS
from seoro.bridges.launch import folder_for_sockets
from seoro.concurrency.background import background
from seoro.errors import BackendError

NAME: Final = "this-machine"
SHOWN: Final = "this machine"
_JOBS: Final = max(2, (os.cpu_count() or 1) // 2)
_READY: Final = "Ctrl-C ends it"  # in the line that `seoro serve` prints when it listens
_START: Final = 60.0  # [s]
_STOP: Final = 20.0  # [s] for active runs to clean up
_MOST_SITES: Final = 100  # of a user at a time
_POLICY_FILE: Final = "policy.yaml"
_TRUSTED: Final = f"""# The user of the site may run the same with `seoro exec`.
everybody:
  allow: [python, files, network, {", ".join(RUNNING_PROGRAMS)}]
  sandbox: "off"
"""


@dataclass(frozen=True)
class PrivateExecutor:
    """A running executor of a site.

    Args:
        endpoint: Its endpoint, a socket file of this user.
        folder: Its folder.
        process: Its process.
    """

    endpoint: str
    folder: Path
    process: Process


@asynccontextmanager
async def private_executor(state: Path, *, is_trusted: bool) -> AsyncIterator[PrivateExecutor]:
    """Run an executor while the block lasts.

    Args:
        state: Folder for the runs of sites; each active site has a folder in it.
        is_trusted: Whether only the user of this machine starts runs; they may do what `seoro exec` may do. Runs
            of others have the permissions and the sandbox of `seoro serve`.

    Raises:
        BackendError: The executor does not start.
        OSError: The folder cannot be written.
    """
    with _claimed(state) as folder, _sockets() as sockets:
        endpoint = f"unixsock-stream/{sockets / 'hub.sock'}"
        command = [sys.executable, "-m", "seoro", "serve", "--name", NAME, "--listen", endpoint]
        command += ["--folder", str(folder), "--jobs", str(_JOBS), "--die-with-parent"]
        if is_trusted:
            policy = sockets / _POLICY_FILE
            policy.write_text(_TRUSTED, encoding="utf-8")
            command += ["--policy", str(policy)]
        async with _running(command) as (process, lines), background() as tasks:
            await _await_start(lines)
            tasks.start_soon(_drop, lines)
            yield PrivateExecutor(endpoint, folder, process)


@contextmanager
def _claimed(state: Path) -> Iterator[Path]:
    """Claim a folder that no other site uses."""
    state.mkdir(parents=True, exist_ok=True, mode=0o700)
    for number in range(1, _MOST_SITES + 1):
        with (state / f"{number}.lock").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                continue
            yield state / str(number)
            return
    raise BackendError(f"too many sites: all folders in {state} are in use")


@contextmanager
def _sockets() -> Iterator[Path]:
    """Make a folder for the socket of the executor and its policy."""
    with tempfile.TemporaryDirectory(prefix="seoro-", dir=folder_for_sockets()) as name:
        yield Path(name)


@asynccontextmanager
async def _running(command: list[str]) -> AsyncIterator[tuple[Process, AsyncIterator[str]]]:
    """Run a process in its own session, so that Ctrl-C in the terminal reaches the site only."""
    process = await anyio.open_process(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=None, start_new_session=True
    )
    try:
        yield process, _lines(process)
    finally:
        with anyio.CancelScope(shield=True):
            await _stop(process)


async def _stop(process: Process) -> None:
    """End a process by closing its input, or kill it."""
    assert process.stdin is not None
    with suppress(anyio.BrokenResourceError, anyio.ClosedResourceError):
        await process.stdin.aclose()
    with anyio.move_on_after(_STOP):
        await process.wait()
    if process.returncode is None:
        process.kill()
        await process.wait()
    await process.aclose()


async def _lines(process: Process) -> AsyncIterator[str]:
    assert process.stdout is not None
    rest = ""
    async for text in TextReceiveStream(process.stdout, errors="replace"):
        *whole, rest = (rest + text).split("\n")
        for line in whole:
            yield line


async def _await_start(lines: AsyncIterator[str]) -> None:
    with anyio.move_on_after(_START):
        async for line in lines:
            if _READY in line:
                return
    raise BackendError("the executor of this machine did not start; it prints the reason on stderr")


async def _drop(lines: AsyncIterator[str]) -> None:
    async for _ in lines:
        pass
