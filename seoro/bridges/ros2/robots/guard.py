"""The guard of a bridge: a process that stops the robots when the bridge cannot any more.

It is started as `python -m seoro.bridges.ros2.robots.guard SETTINGS` with a pipe from the bridge as stdin, says a
line on stdout when it is on guard, and needs nothing else of the bridge. A byte in the pipe is a sign of life, and
`END` comes from a bridge that has stopped its robots itself. Alarms come from a thread of the bridge that hears of
emergency stops: the guard stops these robots, and need not wait for what the bridge does. When the pipe ends
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
from collections.abc import Callable, Collection, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass
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
from seoro.bridges.wire.refusal import listed
from seoro.errors import SeoroError
from seoro.terminal_text import log_to_stderr

PERIOD: Final = 0.05  # [s] between two signs of life
SIGN: Final = b"."
PENDING: Final = b"?"  # a sign of a bridge that has sent goals of which nobody has said yet whether they are taken
ALARM: Final = 0x80  # a sign with this bit: an emergency stop of a robot has to be carried out
ALARMS: Final = 0x80  # different ones: with more robots, some share one, and are stopped together
END: Final = b"e"
LINGER: Final = (
    30.0  # [s] for which goals of a bridge that was killed are canceled, if the robot is not reached at once
)

log = logging.getLogger(__name__)


class GuardedRobot(BaseModel):
    """What the guard has to know of a robot: its name and namespace, its driving, and the names of its actions."""

    model_config = ConfigDict(frozen=True)

    name: str
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


@dataclass(frozen=True)
class _Handle:
    """A robot as the guard stops it: its name, its actions as ROS 2 resolves them, and how it is driven."""

    name: str
    actions: tuple[str, ...]
    velocity: Velocity | None


def alarms_of(robots: Sequence[str], stopped: Collection[str]) -> bytes:
    """The signs of emergency stops of some of the robots of a bridge."""
    return bytes({ALARM | index % ALARMS for index, robot in enumerate(robots) if robot in stopped})


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
        handles = await _take_over(settings.robots, system, senders, stack, tasks)
        ready()

        def stop(robots: Collection[int], why: str) -> None:
            log.warning("the bridge %s: stopping %s", why, listed(handles[each].name for each in robots))
            for handle in (handles[each] for each in robots):
                senders.give_up(settings.session, handle.actions)
                if handle.velocity is not None:
                    handle.velocity.stop()

        def go_on(robots: Collection[int]) -> None:
            for each in robots:
                senders.take_back(settings.session, handles[each].actions)

        everything = range(len(handles))
        last = await last_sign(pipe, len(handles), stop, go_on)
        if last != END:
            stop(everything, "was killed")
            await anyio.sleep(STOPPING)
            with anyio.move_on_after(LINGER):
                if last == PENDING:
                    await anyio.sleep_forever()
                await senders.wait_without_goals(settings.session)


async def _take_over(
    robots: Sequence[GuardedRobot], system: RosSystem, senders: Senders, stack: AsyncExitStack, tasks: TaskGroup
) -> list[_Handle]:
    """Follow the goals of all robots, and be ready to command those that drive."""
    for type_name in (*TYPES, f"{CANCEL_GOAL}_Request"):
        system.types.prepare(type_name)  # which takes a quarter of a second, which there is not later
    handles: list[_Handle] = []
    for robot in robots:
        node = await stack.enter_async_context(system.node(GUARD, robot.namespace))
        for action in robot.actions:
            await tasks.start(end_leftovers, node, action, senders, log.warning)
        velocity = None
        if robot.limits is not None:
            link = Link(node, stack, tasks)
            velocity = Velocity(link, robot.cmd_vel, robot.limits, lambda _: None)  # the bridge says it, too
            tasks.start_soon(velocity.find)
            tasks.start_soon(velocity.run)
        handles.append(_Handle(robot.name, tuple(map(node.resolve, robot.actions)), velocity))
    return handles


async def last_sign(
    pipe: int,
    robots: int,
    stop: Callable[[Collection[int], str], None],
    go_on: Callable[[Collection[int]], None],
) -> bytes:
    """Wait for the end of the bridge, and return the last sign that it has given: `END` if it has said so.

    Args:
        pipe: The file on which it gives signs of life.
        robots: How many robots the bridge has.
        stop: Called with the numbers of robots and why: of all when there is no sign, of some at an alarm.
        go_on: Called with them when there are signs again, or the alarm is over.
    """
    everything, stopped, last = frozenset(range(robots)), frozenset[int](), SIGN
    hangs = False
    while True:
        with anyio.move_on_after(None if hangs else SILENCE):
            await anyio.wait_readable(pipe)
        # On a busy machine, a sign may have come that nobody has had the time to see.
        if not hangs and not select.select([pipe], [], [], 0.0)[0]:
            hangs, stopped = True, everything
            stop(everything, f"has given no sign of life for {SILENCE:g} s")
            continue
        signs, hangs = os.read(pipe, 4096), False
        last = signs[-1:] or last
        if not signs or last == END:
            return last
        if alarmed := _robots_of(signs, robots) - stopped:
            stop(alarmed, "has to stop robots in an emergency")
        stopped |= alarmed
        if over := stopped - _robots_of(_last_alarms(signs), robots):
            go_on(over)
        stopped -= over


def _robots_of(signs: bytes, robots: int) -> frozenset[int]:
    """Numbers of the robots that alarms among signs are for."""
    alarms = {sign & ~ALARM for sign in signs if sign & ALARM}
    return frozenset(number for number in range(robots) if number % ALARMS in alarms)


def _last_alarms(signs: bytes) -> bytes:
    """The alarms after all other signs, which still hold."""
    return signs[len(signs.rstrip(bytes(range(ALARM, ALARM + ALARMS)))) :]


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
