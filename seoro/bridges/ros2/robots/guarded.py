"""Being guarded: a bridge's side of its guard (`guard.py`)."""

from __future__ import annotations

import logging
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import Process, TaskStatus

from seoro.background import background
from seoro.bridges.ros2.robots.guard import END, PERIOD, SIGN, GuardSettings
from seoro.errors import BackendError

READY_WITHIN: Final = 30.0  # [s] from its start until it is on guard
ENDED_WITHIN: Final = 3.0  # [s] from being told
ANEW_AFTER: Final = 1.0  # [s] from its end until another is started

log = logging.getLogger(__name__)


@asynccontextmanager
async def guarded(settings: GuardSettings) -> AsyncIterator[None]:
    """Have a process stop the robots of this one if that cannot do so any more, for as long as the block lasts.

    Raises:
        BackendError: The guard does not start.
    """
    async with background() as tasks:
        await tasks.start(_keep_guarded, settings)
        yield


async def _keep_guarded(settings: GuardSettings, *, task_status: TaskStatus[None] = TASK_STATUS_IGNORED) -> None:
    async with _guard(settings) as guard:
        task_status.started()
        await _give_signs(guard)
    while True:
        log.warning("the guard of the bridge has ended, and is started again")
        await anyio.sleep(ANEW_AFTER)
        try:
            async with _guard(settings) as guard:
                await _give_signs(guard)
        except BackendError as error:
            log.warning("%s", error)


@asynccontextmanager
async def _guard(settings: GuardSettings) -> AsyncIterator[Process]:
    """A guard that is on guard; it is told when the block ends.

    Raises:
        BackendError: It does not start.
    """
    command = [sys.executable, "-m", "seoro.bridges.ros2.robots.guard", settings.model_dump_json()]
    process = await anyio.open_process(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=None, start_new_session=True
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        said = b""
        with anyio.move_on_after(READY_WITHIN), suppress(anyio.EndOfStream):
            said = await process.stdout.receive()
        if not said:
            raise BackendError("the guard of the bridge, which stops the robots if it is killed, does not start")
        yield process
    finally:
        with anyio.CancelScope(shield=True):
            with anyio.move_on_after(ENDED_WITHIN), suppress(OSError, anyio.BrokenResourceError):
                await process.stdin.send(END)
                await process.wait()
            if process.returncode is None:
                process.kill()
            await process.aclose()


async def _give_signs(guard: Process) -> None:
    """Give signs of life until the guard has ended."""
    assert guard.stdin is not None
    with suppress(OSError, anyio.BrokenResourceError):
        while True:
            await guard.stdin.send(SIGN)
            await anyio.sleep(PERIOD)
