"""Node of robots: serves their verbs, leases them, and stops them when their holder is lost."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Sequence
from concurrent.futures import Future
from contextlib import asynccontextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from seoro import __version__
from seoro.bridges import wire
from seoro.bridges.leasing.emergency_stop import EmergencyStopState, selected_robots
from seoro.bridges.leasing.event_filter import events_for, scoped_id
from seoro.bridges.leasing.leases import Hold, Leases
from seoro.bridges.serving.admission import AdmissionLimits
from seoro.bridges.serving.answering import answer
from seoro.bridges.serving.emergency import StopThread, stop_thread, subscribing_to_stops
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.robot import Carry, ServedRobot, robot_state
from seoro.bridges.serving.watchdog import Watchdog
from seoro.bridges.serving.work import Work
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, name_list, read_request
from seoro.concurrency.background import background
from seoro.security.network.authorizer import NodeAuthorizer, open_authorizer
from seoro.security.network.listener import Listener

WAITING = Bound(256, drop="newest")  # requests
SETTLED_WITHIN = 1.0  # [s] for goals to end before an emergency stop is acknowledged
STOP_DEADLINE = 3.0  # [s] for robots to stop at the end
KIND = "bridge"  # in messages

SetAlarm: TypeAlias = Callable[[Collection[str], bool], object]
"""Called with robots and True before they are stopped in an emergency, and with False after that."""


def no_alarm(_robots: Collection[str], _is_on: bool) -> None:
    """Ignore alarms."""


@asynccontextmanager
async def serving(
    listener: Listener,
    name: str,
    make: Callable[[Work, EventLog], Sequence[ServedRobot]],
    state: Path | None = None,
    log: Path | None = None,
    alarm: SetAlarm = no_alarm,
) -> AsyncIterator[RobotServer]:
    """Serve robots while the block lasts; they stop at its end.

    Args:
        listener: Listener of the node.
        name: Name of the node.
        make: Factory of the robots, which report goals and watches to its arguments.
        state: File that keeps an emergency stop across restarts; None to keep none.
        log: File of the audit log; required with keys.
        alarm: Called from any thread; see `SetAlarm`.

    Raises:
        UsageError: The log cannot be written, or another node has the name.
    """
    events, boot = EventLog(), secrets.token_hex(8)
    with open_authorizer(listener, log) as authorizer:
        async with background() as reached, background() as tasks:
            work = Work(tasks, events)
            server = RobotServer(
                make(work, events), work, events, tasks, EmergencyStopState(state), authorizer, alarm
            )
            reached.start_soon(server.watchdog.watch_deadlines)
            try:
                with stop_thread(
                    authorizer.identity, server.stop_at_once, server.save_stop, listener.namespace
                ) as stops:
                    await reached.start(
                        listener.serve, partial(_served, server, name, boot, tasks, stops, listener)
                    )
                    yield server
            finally:
                with anyio.move_on_after(STOP_DEADLINE, shield=True):
                    await server.end("the bridge ends")


@asynccontextmanager
async def _served(
    server: RobotServer,
    name: str,
    boot: str,
    tasks: TaskGroup,
    stops: StopThread,
    listener: Listener,
    session: AsyncSession,
) -> AsyncIterator[None]:
    """Serve the node at a session; `boot` identifies the start of its process."""
    intake = AdmissionLimits(server.verbs, "node", stop=stops.on_request)
    key = wire.node_command(wire.NAMESPACE, name, "*")
    server.watchdog.lose_connection()
    async with (
        session.tokens(wire.holder_tokens(wire.NAMESPACE)) as tokens,
        subscribing_to_stops(stops, listener, session),
        session.answering(key, WAITING, intake.busy, intake, server.authorizer.attestor) as requests,
        session.token(wire.node_token(wire.NAMESPACE, name, boot)),
        background() as duties,
    ):
        duties.start_soon(server.watchdog.watch_tokens, tokens)
        duties.start_soon(_answer, server, requests, tasks)
        yield


async def _answer(server: RobotServer, requests: Mailbox[Request], tasks: TaskGroup) -> None:
    async for request in requests:
        tasks.start_soon(server.answer, request)
        await asyncio.sleep(0)  # one at a time, so that many requests do not block the event loop


class RobotServer:
    """Carries out requests. Made by `serving`. Methods that are named like verbs handle them.

    Args:
        robots: Robots of the node.
        work: Their goals and watches.
        events: Events of the robots.
        tasks: Tasks that stop the robots of lost clients.
        emergency: State of the emergency stop.
        authorizer: Authorizer of requests.
        alarm: See `serving`.
    """

    def __init__(
        self,
        robots: Sequence[ServedRobot],
        work: Work,
        events: EventLog,
        tasks: TaskGroup,
        emergency: EmergencyStopState,
        authorizer: NodeAuthorizer,
        alarm: SetAlarm = no_alarm,
    ) -> None:
        self.authorizer = authorizer
        self._robots = {robot.info.name: robot for robot in robots}
        self._work = work
        self._events = events
        self._emergency = emergency
        self._alarm = alarm
        self._tasks = tasks
        self._loop = asyncio.get_running_loop()
        self._leases = Leases(lambda: self._robots)
        self._ended = ""  # reason of the end of the node
        self._carried: dict[anyio.CancelScope, str] = {}  # requests in progress, with their robots
        self.watchdog = Watchdog(self._leases, self._stop_held, tasks)
        self._own = {verb.name: verb for verb in wire.NODE_VERBS.values() if hasattr(self, verb.name)}
        self._theirs = {
            name: {verb.name: (verb, carry) for verb, carry in robot.handlers.items()}
            for name, robot in self._robots.items()
        }

    @property
    def verbs(self) -> frozenset[wire.Verb[Any, Any]]:
        """Served verbs."""
        served = (verb for named in self._theirs.values() for verb, _ in named.values())
        return frozenset({wire.CHALLENGE, wire.EMERGENCY_STOP, *self._own.values(), *served})

    @property
    def _verbs(self) -> frozenset[str]:
        return frozenset({wire.EMERGENCY_STOP.name}).union(self._own, *self._theirs.values())

    async def end(self, reason: str) -> None:
        """Stop all robots, interrupt their goals for a reason, and refuse later requests."""
        self._ended = reason
        await self.stop(reason)

    async def stop(self, reason: str) -> None:
        """Stop all robots, and interrupt their goals for a reason."""
        await self._stop_robots(tuple(self._robots), reason)

    async def _stop_held(self, hold: Hold, reason: str) -> None:
        await self._stop_robots(self._leases.robots_of(hold), reason)

    async def _stop_robots(self, names: Collection[str], reason: str) -> None:
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(self._halt, name)
            tasks.start_soon(self._work.interrupt, reason, names)

    async def _halt(self, name: str) -> None:
        """Cancel the requests of a robot in progress, and command zero velocity."""
        for scope, robot in self._carried.items():
            if robot == name:
                scope.cancel()
        await self._robots[name].stop()

    async def answer(self, request: Request) -> None:
        """Carry out a request and reply to it."""
        await answer(request, partial(self._admit, request), KIND)

    async def _admit(self, request: Request, name: str, payload: bytes) -> wire.Message | None:
        if name == wire.CHALLENGE.name:
            return self.authorizer.prove(payload)
        with self.authorizer.admitted(request, self._leases.key_of) as sender:
            return await self._carry_out(sender, name, payload)

    async def _carry_out(self, sender: str, name: str, payload: bytes) -> wire.Message | None:
        if self._ended:
            raise RequestRefused(wire.LabResult.UNAVAILABLE, self._ended)
        if (verb := self._own.get(name)) is not None:
            self.authorizer.check_holder(verb, sender, asked := read_request(verb, payload))
            handler: Carry = getattr(self, name)
            return await handler(asked)
        serving = {robot: verbs[name] for robot, verbs in self._theirs.items() if name in verbs}
        if not serving:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"unsupported verb {name!r} (verbs of this bridge: {name_list(self._verbs)})",
            )
        verb = next(iter(serving.values()))[0]
        request = read_request(verb, payload)
        robot = self._find_robot(sender, name, request)
        if not verb.is_read_only:
            self._emergency.check(robot)
            self._leases.check(sender, robot, has_to_hold=True)
        if robot not in serving:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"the robot '{robot}' does not support {name!r}")
        return await self._carry_unless_stopped(robot, serving[robot][1](request))

    async def _carry_unless_stopped(
        self, robot: str, carried: Awaitable[wire.Message | None]
    ) -> wire.Message | None:
        """Carry out a request; it is cancelled when the robot is stopped."""
        with anyio.CancelScope() as scope:
            self._carried[scope] = robot
            try:
                return await carried
            finally:
                del self._carried[scope]
        self._emergency.check(robot)
        raise RequestRefused(wire.LabResult.NOT_HELD, f"the robot '{robot}' was stopped")

    def _find_robot(self, sender: str, verb: str, request: wire.Message) -> str:
        """Return the robot of a request; without a name, the first one of the client that supports the verb."""
        if isinstance(request, wire.WatchProximity) and not request.robot:
            return self._owner(request.frame)
        name: str = getattr(request, "robot", "")
        if not name and verb == wire.CMD_VEL.name:
            hold = self._leases.hold_of(sender)
            able = [robot for robot, verbs in self._theirs.items() if verb in verbs]
            return next((robot for robot in able if hold is not None and hold.holds(robot)), able[0])
        self._check(name)
        return name

    def _owner(self, frame: str) -> str:
        """Return the first robot with a frame."""
        for name, each in self._robots.items():
            if frame in each.info.frames:
                return name
        known = {known for each in self._robots.values() for known in each.info.frames}
        raise RequestRefused(Result.NOT_FOUND, f"unknown frame '{frame}' (frames: {name_list(known)})")

    def _check(self, robot: str) -> None:
        if robot not in self._robots:
            raise RequestRefused(Result.NOT_FOUND, f"unknown robot '{robot}' (robots: {name_list(self._robots)})")

    # -------------------------------------------------------- verbs of all robots

    async def get_robot_features(self, _request: wire.Empty) -> wire.RobotFeatures:
        return self._features_of(tuple(self._robots))

    def _features_of(self, names: Sequence[str]) -> wire.RobotFeatures:
        return wire.RobotFeatures(
            version=__version__,
            features=tuple(sorted(self._verbs)),
            robots=tuple(self._info(name) for name in names),
            number=self._events.number,
            holder=self._leases.holder_names(names),
        )

    def _info(self, name: str) -> wire.RobotInfo:
        verbs = sorted({*self._own, *self._theirs[name]})
        return self._robots[name].info.model_copy(update={"verbs": tuple(verbs)})

    async def take_robots(self, holder: wire.Holder) -> wire.RobotFeatures:
        self._emergency.check(*(holder.robots or self._robots))
        for gone in self._leases.acquire(holder, self._events.now):
            await self._work.cancel_all(scoped_id(gone.holder.holder, ""))
        hold = self._leases.renew(holder.holder)
        self.watchdog.wake()
        return self._features_of(self._leases.robots_of(hold))

    async def hold_robots(self, request: wire.HoldRobots) -> wire.LoggedEvents:
        hold = self._leases.renew(request.holder)
        self.watchdog.wake()
        robots = self._leases.robots_of(hold)
        self._emergency.check(*robots)
        happened = await self._events.after(request)
        self._emergency.check(*robots)
        return events_for(hold, happened)

    async def release_robots(self, holder: wire.Holder) -> None:
        hold = self._leases.hold_of(holder.holder)
        if hold is not None:
            await self._stop_robots(self._leases.robots_of(hold), "the run has ended")
            await self._work.cancel_all(scoped_id(holder.holder, ""))
        self._leases.release(holder.holder, waits=holder.waits)

    async def stop_robot(self, request: wire.StopRobot) -> None:
        self._check(request.robot)
        await self._stop_robots({request.robot}, "the robot was stopped")

    async def cancel_goal(self, request: wire.CancelGoal) -> None:
        await self._work.cancel(request.id)

    async def cancel_watch(self, request: wire.CancelWatch) -> wire.CancelledWatch:
        await self._work.cancel(request.id)
        return wire.CancelledWatch()  # its watches have no measures

    # -------------------------------------------------------- the lab

    async def get_lab_state(self, _request: wire.Empty) -> wire.LabState:
        received = time.time()
        return wire.LabState(
            kind=KIND,
            version=__version__,
            robots=tuple(
                robot_state(robot.info, robot.health, self._leases, self._emergency)
                for robot in self._robots.values()
            ),
            stopped=self._emergency.stopped,
            holder=self._leases.name_of_sole_holder,
            received=received,
            sent=time.time(),
        )

    async def lease_robots(self, request: wire.LeaseRobots) -> None:
        self._leases.lease(request)

    async def release_lease(self, request: wire.ReleaseLease) -> None:
        self._leases.end_lease(request)

    def stop_at_once(self, asked: wire.EmergencyStop) -> Future[wire.StopAcknowledgement]:
        """Block all robots, or the named ones, until a release; from any thread.

        The event loop then stops them. If it is busy, the guard of the bridge stops them.

        Raises:
            RequestRefused: All named robots are unknown.
        """
        names = selected_robots(asked.robots, self._robots)
        self._emergency.stop(asked.model_copy(update={"robots": names if asked.robots else ()}))
        self._alarm(names, True)
        stopped: Future[wire.StopAcknowledgement] = Future()
        with suppress(RuntimeError):  # the bridge ends
            self._loop.call_soon_threadsafe(self._tasks.start_soon, self._stop_named, names, stopped)
        return stopped

    def save_stop(self) -> None:
        """Save the state of the emergency stop."""
        self._emergency.save()

    async def _stop_named(self, names: tuple[str, ...], stopped: Future[wire.StopAcknowledgement]) -> None:
        try:
            stopped.set_result(await self._stop_in_emergency(names))
        finally:
            self._alarm(names, False)

    async def _stop_in_emergency(self, names: tuple[str, ...]) -> wire.StopAcknowledgement:
        began = time.monotonic()
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(self._halt, name)
        took = time.monotonic() - began
        self._events.wake()
        over = anyio.Event()
        self._tasks.start_soon(self._abort_goals, names, over)
        with anyio.move_on_after(SETTLED_WITHIN):
            await over.wait()
        return wire.StopAcknowledgement(stopped=names, took=took, unsettled=self._work.busy(names))

    async def _abort_goals(self, names: tuple[str, ...], over: anyio.Event) -> None:
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(self._work.interrupt, self._emergency.reason_of(name), {name})
        over.set()

    async def release_stop(self, request: wire.ReleaseStop) -> None:
        await anyio.to_thread.run_sync(self._emergency.release, request)
