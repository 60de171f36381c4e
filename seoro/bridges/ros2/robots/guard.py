"""Guard of a bridge: a process that stops the robots when the bridge is killed or hangs.

It is started as `python -m seoro.bridges.ros2.robots.guard SETTINGS` with a pipe from the bridge as stdin, and
prints a line when it is ready. A byte in the pipe is a heartbeat; `END` comes from a bridge that has stopped its
robots itself. Alarms come from a thread of the bridge that receives emergency stops: the guard stops these robots
at once, even if the bridge hangs. If the pipe ends without `END`, the bridge was killed; without a heartbeat for a
while, it hangs. In both cases, the guard commands zero velocity and cancels the goals. If the last heartbeat was
`PENDING`, a goal may still be accepted, and the guard waits for it.

Goals of other processes of seoro are canceled, too (`orphaned_goals.py`): goals of a bridge that has died together
with its guard, and of runs that were killed.
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

from seoro.bridges.ros2.clients.cancellation import CANCEL_GOAL
from seoro.bridges.ros2.participant import GUARD, RosOptions, RosSystem, connect_system
from seoro.bridges.ros2.robots.guard_state import SILENCE
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.orphaned_goals import GoalSenders, cancel_orphaned_goals
from seoro.bridges.ros2.robots.profile import BridgedRobot
from seoro.bridges.ros2.robots.velocity import STOPPING, TYPES, Velocity
from seoro.bridges.wire.refusal import name_list
from seoro.concurrency.background import background
from seoro.errors import SeoroError
from seoro.text.logs import log_to_stderr

PERIOD: Final = 0.1  # [s] between two heartbeats
HEARTBEAT: Final = b"."
PENDING: Final = b"?"  # heartbeat of a bridge with unanswered goals
ALARM: Final = 0x80  # bit of the alarms: a robot has a pending emergency stop
ALARMS: Final = 0x80  # number of different alarms; with more robots, some share an alarm, and are stopped together
END: Final = b"e"
LINGER: Final = (
    30.0  # [s] for which the goals of a killed bridge are canceled, if the robot is unreachable at once
)

log = logging.getLogger(__name__)


class GuardSettings(BaseModel):
    """Settings of a guard: the connection to the ROS 2 system, the session of the bridge, and its robots."""

    model_config = ConfigDict(frozen=True)

    ros: RosOptions
    session: str
    robots: tuple[BridgedRobot, ...]


@dataclass(frozen=True)
class _Handle:
    """Access to a robot: its name, the full names of its actions, and its velocity commands."""

    name: str
    actions: tuple[str, ...]
    velocity: Velocity | None


def encode_alarms(robots: Sequence[str], stopped: Collection[str]) -> bytes:
    """Encode the emergency stops of some of the robots of a bridge."""
    return bytes({ALARM | index % ALARMS for index, robot in enumerate(robots) if robot in stopped})


async def guard(settings: GuardSettings, pipe: int, ready: Callable[[], None]) -> None:
    """Guard a bridge until it ends.

    Args:
        settings: Settings of the guard.
        pipe: File with the heartbeats of the bridge.
        ready: Called when the bridge is guarded.

    Raises:
        BackendError: The ROS 2 system is unreachable.
    """
    async with (
        connect_system(settings.ros) as system,
        AsyncExitStack() as stack,
        background() as tasks,
    ):
        senders = GoalSenders(system.graph)
        handles = await _follow_robots(settings.robots, system, senders, stack, tasks)
        ready()

        def stop(robots: Collection[int], reason: str) -> None:
            log.warning("the bridge %s: stopping %s", reason, name_list(handles[each].name for each in robots))
            for handle in (handles[each] for each in robots):
                senders.disown(settings.session, handle.actions)
                if handle.velocity is not None:
                    handle.velocity.stop()

        def resume(robots: Collection[int]) -> None:
            for each in robots:
                senders.reclaim(settings.session, handles[each].actions)

        last = await watch_heartbeats(pipe, len(handles), stop, resume)
        if last != END:
            stop(range(len(handles)), "was killed")
            await anyio.sleep(STOPPING)
            with anyio.move_on_after(LINGER):
                if last == PENDING:
                    await anyio.sleep_forever()
                await senders.wait_without_goals(settings.session)


async def _follow_robots(
    robots: Sequence[BridgedRobot],
    system: RosSystem,
    senders: GoalSenders,
    stack: AsyncExitStack,
    tasks: TaskGroup,
) -> list[_Handle]:
    """Follow the goals of all robots, and prepare velocity commands for robots that drive."""
    for type_name in (*TYPES, f"{CANCEL_GOAL}_Request"):
        system.types.prepare(type_name)  # takes a quarter of a second, which would delay a stop
    handles: list[_Handle] = []
    for robot in robots:
        node = await stack.enter_async_context(system.node(GUARD, robot.namespace))
        base, actions = robot.profile.base, robot.profile.actions
        for action in actions:
            await tasks.start(cancel_orphaned_goals, node, action, senders, log.warning)
        velocity = None
        if base is not None:
            link = Link(node, stack, tasks)
            velocity = Velocity(link, base.cmd_vel, base.limits, lambda _: None)  # the bridge logs it, too
            tasks.start_soon(velocity.find)
            tasks.start_soon(velocity.run)
        handles.append(_Handle(robot.name, tuple(map(node.resolve, actions)), velocity))
    return handles


async def watch_heartbeats(
    pipe: int,
    robots: int,
    stop: Callable[[Collection[int], str], None],
    resume: Callable[[Collection[int]], None],
) -> bytes:
    """Watch a bridge until it ends; return its last heartbeat, which is `END` after a regular end.

    Args:
        pipe: File with the heartbeats of the bridge.
        robots: Number of robots of the bridge.
        stop: Called with the numbers of robots and a reason: all without a heartbeat, some at an alarm.
        resume: Called with them when heartbeats continue, or when the alarm is over.
    """
    everything, stopped, last = frozenset(range(robots)), frozenset[int](), HEARTBEAT
    hangs = False
    while True:
        with anyio.move_on_after(None if hangs else SILENCE):
            await anyio.wait_readable(pipe)
        # On a busy machine, a heartbeat may have arrived after the timeout.
        if not hangs and not select.select([pipe], [], [], 0.0)[0]:
            hangs, stopped = True, everything
            stop(everything, f"has sent no heartbeat for {SILENCE:g} s")
            continue
        received, hangs = os.read(pipe, 4096), False
        last = received[-1:] or last
        if not received or last == END:
            return last
        if alarmed := _alarmed_robots(received, robots) - stopped:
            stop(alarmed, "has to stop robots in an emergency")
        stopped |= alarmed
        if over := stopped - _alarmed_robots(_last_alarms(received), robots):
            resume(over)
        stopped -= over


def _alarmed_robots(received: bytes, robots: int) -> frozenset[int]:
    """Return the numbers of the robots of received alarms."""
    alarms = {byte & ~ALARM for byte in received if byte & ALARM}
    return frozenset(number for number in range(robots) if number % ALARMS in alarms)


def _last_alarms(received: bytes) -> bytes:
    """Return the alarms after all other heartbeats, which still hold."""
    return received[len(received.rstrip(bytes(range(ALARM, ALARM + ALARMS)))) :]


def main() -> None:
    """Guard the bridge that has started this process."""
    for number in (signal.SIGINT, signal.SIGTERM):  # only the bridge reacts to them; the guard ends after it
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
