"""Being guarded: a bridge's side of its guard (`guard.py`)."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import Process, TaskStatus

from seoro.background import background
from seoro.bridges.ros2.robots.alarm import Alarm
from seoro.bridges.ros2.robots.guard import END, PENDING, PERIOD, SIGN, GuardSettings, alarms_of
from seoro.bridges.ros2.robots.standstill import Standstills
from seoro.bridges.ros2.robots.unanswered import Unanswered
from seoro.errors import BackendError

READY_WITHIN: Final = 30.0  # [s] from its start until it is on guard
ENDED_WITHIN: Final = 3.0  # [s] from being told
ANEW_AFTER: Final = 1.0  # [s] from its end until another is started
PATIENCE: Final = 1.0  # [s] that the event loop may be busy with one thing, such as loading definitions

log = logging.getLogger(__name__)


class Signs:
    """Signs of life, given by a thread: work that holds up the event loop for a moment is no standstill.

    Args:
        pipe: The file that the guard reads; it is closed at the end.
        standstills: Told of each sign.
        unanswered: Goals of which they tell, at once.
        alarm: Emergency stops, of which they tell at once, too.
        robots: Names of the robots, in the order of the guard's settings.
    """

    def __init__(
        self,
        pipe: int,
        standstills: Standstills,
        unanswered: Unanswered,
        alarm: Alarm,
        robots: Sequence[str],
    ) -> None:
        os.set_blocking(pipe, False)
        self._pipe = pipe
        self._standstills = standstills
        self._unanswered = unanswered
        self._alarm = alarm
        self._robots = tuple(robots)
        self._turned = time.monotonic()
        self._over = threading.Event()
        self._writing = threading.Lock()  # so that the last sign is what is so
        unanswered.when_changed = alarm.when_changed = self._write
        self._thread = threading.Thread(target=self._give, name="signs of life", daemon=True)
        self._thread.start()

    async def keep_turning(self) -> None:
        """Note that the event loop goes on, without end."""
        while True:
            self._turned = time.monotonic()
            await anyio.sleep(PERIOD)

    def end(self) -> None:
        """Say that the end is well, and give none any more."""
        self._unanswered.when_changed = self._alarm.when_changed = lambda: None
        self._over.set()
        self._thread.join()
        self._standstills.note_end()
        with suppress(OSError):
            os.write(self._pipe, END)
        os.close(self._pipe)

    def _give(self) -> None:
        while not self._over.wait(PERIOD):
            if time.monotonic() - self._turned < PATIENCE:
                self._standstills.note_sign()
                self._write()

    def _write(self) -> None:
        with self._writing, suppress(OSError):  # nobody reads any more, or for a while
            alarms = alarms_of(self._robots, self._alarm.robots)
            os.write(self._pipe, alarms or (PENDING if self._unanswered.is_any else SIGN))


@asynccontextmanager
async def guarded(settings: GuardSettings, unanswered: Unanswered, alarm: Alarm) -> AsyncIterator[Standstills]:
    """Have a process stop the robots of this one if that cannot do so any more, for as long as the block lasts.

    Gives when that was so, of which this process has to know when it goes on.

    Args:
        settings: What the guard has to know.
        unanswered: Goals that may be taken after the end of this process.
        alarm: Emergency stops.

    Raises:
        BackendError: The guard does not start.
    """
    standstills = Standstills()
    async with background() as tasks:
        await tasks.start(_keep_guarded, settings, standstills, unanswered, alarm)
        yield standstills


async def _keep_guarded(
    settings: GuardSettings,
    standstills: Standstills,
    unanswered: Unanswered,
    alarm: Alarm,
    *,
    task_status: TaskStatus[None] = TASK_STATUS_IGNORED,
) -> None:
    async with _guard(settings, standstills, unanswered, alarm) as guard:
        task_status.started()
        await guard.wait()
    while True:
        log.warning("the guard of the bridge has ended, and is started again")
        await anyio.sleep(ANEW_AFTER)
        try:
            async with _guard(settings, standstills, unanswered, alarm) as guard:
                await guard.wait()
        except BackendError as error:
            log.warning("%s", error)


@asynccontextmanager
async def _guard(
    settings: GuardSettings, standstills: Standstills, unanswered: Unanswered, alarm: Alarm
) -> AsyncIterator[Process]:
    """A guard that is on guard; it is told when the block ends.

    Raises:
        BackendError: It does not start.
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
    signs = Signs(ours, standstills, unanswered, alarm, [robot.name for robot in settings.robots])
    try:
        said = b""
        with anyio.move_on_after(READY_WITHIN), suppress(anyio.EndOfStream):
            said = await process.stdout.receive()
        if not said:
            raise BackendError("the guard of the bridge, which stops the robots if it is killed, does not start")
        async with background() as tasks:
            tasks.start_soon(signs.keep_turning)
            yield process
    finally:
        with anyio.CancelScope(shield=True):
            signs.end()
            with anyio.move_on_after(ENDED_WITHIN):
                await process.wait()
            if process.returncode is None:
                process.kill()
            await process.aclose()
