"""The guard of a bridge: a process that stops the robots when the bridge cannot any more.

It is started as `python -m seoro.bridges.ros2.robots.guard SETTINGS` with a pipe from the bridge as stdin, says a
line on stdout when it is on guard, and needs nothing else of the bridge. A byte in the pipe is a sign of life, and
`END` comes from a bridge that has stopped its robots itself. `ALARM` comes from a thread of the bridge that hears
of emergency stops: the guard stops the robots, and need not wait for what the bridge does. When the pipe ends
without `END`, the bridge was killed; when no sign comes for a while, it hangs. Either way velocities are zero, and
its goals are canceled; where the last sign was `PENDING`, a goal may yet be taken, and is waited for.

Goals that other processes of seoro have left behind are canceled, too (`leftovers.py`): of a bridge that has died
together with its guard, and of runs that were killed.
"""

from __future__ import annotations

import logging
import os
import select
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import AsyncExitStack
from typing import Final

import anyio
from anyio.abc import TaskGroup
from pydantic import BaseModel, ConfigDict

from seoro.background import background
from seoro.bridges.ros2.clients.recall import CANCEL_GOAL
from seoro.bridges.ros2.own_nodes import GUARD
from seoro.bridges.ros2.participant import RosSystem, connect
from seoro.bridges.ros2.robots.leftovers import Senders, end_leftovers
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.profile import Limits
from seoro.bridges.ros2.robots.standstill import SILENCE
from seoro.bridges.ros2.robots.velocity import STOPPING, TYPES, Velocity
from seoro.bridges.ros2.wire import RmwZenoh, Ros2Dds
from seoro.errors import SeoroError
from seoro.terminal_text import log_to_stderr

PERIOD: Final = 0.05  # [s] between two signs of life
SIGN: Final = b"."
PENDING: Final = b"?"  # a sign of a bridge that has sent goals of which nobody has said yet whether they are taken
ALARM: Final = b"!"  # a sign of a bridge that has an emergency stop to carry out
END: Final = b"e"
LINGER: Final = (
    30.0  # [s] for which goals of a bridge that was killed are canceled, if the robot is not reached at once
)

log = logging.getLogger(__name__)


class GuardedRobot(BaseModel):
    """What the guard has to know of a robot: its namespace, how it is driven, and the names of its actions."""

    model_config = ConfigDict(frozen=True)

    namespace: str
    cmd_vel: str
    limits: Limits | None
    actions: tuple[str, ...]


class GuardSettings(BaseModel):
    """A guard: how the ROS 2 system is reached, the session of the bridge, and its robots."""

    model_config = ConfigDict(frozen=True)

    ros: str
    domain: int
    is_rmw_zenoh: bool
    session: str
    robots: tuple[GuardedRobot, ...]


async def guard(settings: GuardSettings, pipe: int, ready: Callable[[], None]) -> None:
    """Guard a bridge until it ends.

    Args:
        settings: What for.
        pipe: The file on which it gives signs of life.
        ready: Called when it is guarded.

    Raises:
        BackendError: The ROS 2 system is not reached.
    """
    dialect = RmwZenoh(settings.domain) if settings.is_rmw_zenoh else Ros2Dds()
    async with (
        connect(settings.ros, dialect=dialect, domain=settings.domain) as system,
        AsyncExitStack() as stack,
        background() as tasks,
    ):
        senders = Senders(system.graph)
        velocities = await _take_over(settings.robots, system, senders, stack, tasks)
        ready()

        def stop(why: str) -> None:
            log.warning("the bridge %s: its robots are stopped", why)
            senders.give_up(settings.session)
            for velocity in velocities:
                velocity.stop()

        def go_on() -> None:
            senders.take_back(settings.session)

        last = await last_sign(pipe, stop, go_on)
        if last != END:
            stop("was killed")
            await anyio.sleep(STOPPING)
            with anyio.move_on_after(LINGER):
                if last == PENDING:
                    await anyio.sleep_forever()
                await senders.wait_without_goals(settings.session)


async def _take_over(
    robots: Sequence[GuardedRobot], system: RosSystem, senders: Senders, stack: AsyncExitStack, tasks: TaskGroup
) -> list[Velocity]:
    """Follow the goals of all robots, and be ready to command those that drive."""
    for type_name in (*TYPES, f"{CANCEL_GOAL}_Request"):
        system.types.prepare(type_name)  # which takes a quarter of a second, which there is not later
    velocities: list[Velocity] = []
    for robot in robots:
        node = await stack.enter_async_context(system.node(GUARD, robot.namespace))
        for action in robot.actions:
            await tasks.start(end_leftovers, node, action, senders, log.warning)
        if robot.limits is not None:
            link = Link(node, stack, tasks)
            velocity = Velocity(link, robot.cmd_vel, robot.limits, lambda _: None)  # the bridge says it, too
            tasks.start_soon(velocity.find)
            tasks.start_soon(velocity.run)
            velocities.append(velocity)
    return velocities


async def last_sign(pipe: int, stop: Callable[[str], None], go_on: Callable[[], None]) -> bytes:
    """Wait for the end of the bridge, and return the last sign that it has given: `END` if it has said so.

    Args:
        pipe: The file on which it gives signs of life.
        stop: Called when there is none, or an alarm, and with why.
        go_on: Called when there is one again.
    """
    hangs, last = False, SIGN  # it hangs while an alarm is on, too
    while True:
        with anyio.move_on_after(None if hangs else SILENCE):
            await anyio.wait_readable(pipe)
        # On a busy machine, a sign may have come that nobody has had the time to see.
        if not hangs and not select.select([pipe], [], [], 0.0)[0]:
            hangs = True
            stop(f"has given no sign of life for {SILENCE:g} s")
            continue
        signs = os.read(pipe, 4096)
        last = signs[-1:] or last
        if not signs or last == END:
            return last
        if ALARM in signs and not hangs:
            hangs = True
            stop("is told to stop everything")
        if hangs and last != ALARM:
            hangs = False
            go_on()


def main() -> None:
    """Guard the bridge that has started this process."""
    for number in (signal.SIGINT, signal.SIGTERM):  # which are for the bridge: the guard ends after it
        signal.signal(number, signal.SIG_IGN)
    log_to_stderr()

    def ready() -> None:
        sys.stdout.write("ready\n")
        sys.stdout.flush()

    try:
        anyio.run(guard, GuardSettings.model_validate_json(sys.argv[1]), sys.stdin.fileno(), ready)
    except SeoroError as error:
        log.error("the guard of the bridge: %s", error)
        sys.exit(1)


if __name__ == "__main__":
    main()
