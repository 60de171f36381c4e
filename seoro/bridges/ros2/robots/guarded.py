"""Start and heartbeats of the guard of a bridge (`guard.py`)."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import Process, TaskStatus

from seoro.bridges.ros2.robots.guard import END, HEARTBEAT, PENDING, PERIOD, GuardSettings, encode_alarms
from seoro.bridges.ros2.robots.guard_state import GuardState
from seoro.concurrency.background import background
from seoro.errors import BackendError

START_TIMEOUT: Final = 30.0  # [s]
END_TIMEOUT: Final = 3.0  # [s]
RESTART_AFTER: Final = 1.0  # [s] after the end of a guard
PATIENCE: Final = 1.0  # [s] for which the event loop may be blocked, for example by loading definitions

log = logging.getLogger(__name__)


class Heartbeats:
    """Heartbeats sent by a thread, so that short blocking work of the event loop does not count as a standstill.

    Args:
        pipe: File that the guard reads; it is closed at the end.
        state: State of the bridge; changes are sent at once.
        robots: Names of the robots, in the order of the guard's settings.
    """

    def __init__(self, pipe: int, state: GuardState, robots: tuple[str, ...]) -> None:
        os.set_blocking(pipe, False)
        self._pipe = pipe
        self._state = state
        self._robots = robots
        self._last_turn = time.monotonic()
        self._over = threading.Event()
        self._writing = threading.Lock()  # the last write has the latest state
        state.on_change = self._write
        self._thread = threading.Thread(target=self._send, name="heartbeats", daemon=True)
        self._thread.start()

    async def watch_loop(self) -> None:
        """Note that the event loop is running, without end."""
        while True:
            self._last_turn = time.monotonic()
            await anyio.sleep(PATIENCE / 4)

    def end(self) -> None:
        """Announce a regular end, and send no more heartbeats."""
        self._state.on_change = lambda: None
        self._over.set()
        self._thread.join()
        self._state.standstills.note_end()
        with suppress(OSError):
            os.write(self._pipe, END)
        os.close(self._pipe)

    def _send(self) -> None:
        while not self._over.wait(PERIOD):
            if time.monotonic() - self._last_turn < PATIENCE:
                self._state.standstills.note_heartbeat()
                self._write()

    def _write(self) -> None:
        with self._writing, suppress(OSError):  # the guard has ended, or the pipe is full
            alarms = encode_alarms(self._robots, self._state.stopping)
            os.write(self._pipe, alarms or (PENDING if self._state.has_unanswered else HEARTBEAT))


@asynccontextmanager
async def guarded(settings: GuardSettings) -> AsyncIterator[GuardState]:
    """Run a guard during the block: a process that stops the robots if this one is killed or hangs.

    Yield the state that the bridge shares with the guard.

    Raises:
        BackendError: The guard does not start.
    """
    state = GuardState()
    async with background() as tasks:
        await tasks.start(_keep_guarded, settings, state)
        yield state


async def _keep_guarded(
    settings: GuardSettings, state: GuardState, *, task_status: TaskStatus[None] = TASK_STATUS_IGNORED
) -> None:
    async with _guard(settings, state) as guard:
        task_status.started()
        await guard.wait()
    while True:
        log.warning("the guard of the bridge has ended, and is started again")
        await anyio.sleep(RESTART_AFTER)
        try:
            async with _guard(settings, state) as guard:
                await guard.wait()
        except BackendError as error:
            log.warning("%s", error)


@asynccontextmanager
async def _guard(settings: GuardSettings, state: GuardState) -> AsyncIterator[Process]:
    """Start a guard, which ends with the block.

    Raises:
        BackendError: The guard does not start.
    """
    command = [sys.executable, "-m", "seoro.bridges.ros2.robots.guard", settings.model_dump_json()]
    theirs, ours = os.pipe()
    try:
        process = await anyio.open_process(
            command, stdin=theirs, stdout=subprocess.PIPE, stderr=None, start_new_session=True
        )
    except BaseException:
        os.close(ours)
        raise
    finally:
        os.close(theirs)
    assert process.stdout is not None
    heartbeats = Heartbeats(ours, state, tuple(robot.name for robot in settings.robots))
    try:
        output = b""
        with anyio.move_on_after(START_TIMEOUT), suppress(anyio.EndOfStream):
            output = await process.stdout.receive()
        if not output:
            raise BackendError("the guard, which stops the robots if the bridge is killed, does not start")
        async with background() as tasks:
            tasks.start_soon(heartbeats.watch_loop)
            yield process
    finally:
        with anyio.CancelScope(shield=True):
            heartbeats.end()
            with anyio.move_on_after(END_TIMEOUT):
                await process.wait()
            if process.returncode is None:
                process.kill()
            await process.aclose()
