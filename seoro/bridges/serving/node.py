"""A node that serves robots: verbs to robots, one holder, and robots that stop when that is gone."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Sequence
from concurrent.futures import Future
from contextlib import asynccontextmanager, suppress
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from seoro import __version__
from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.door import Door
from seoro.bridges.leasing.latch import Latch, named_here
from seoro.bridges.leasing.leases import Hold, Leases, called
from seoro.bridges.leasing.share import own_id, share_of
from seoro.bridges.serving.answering import answer, decoded
from seoro.bridges.serving.emergency import StopLine, hearing_stops, stop_line
from seoro.bridges.serving.gate import NodeGate, opened_gate
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.hold import Watchdog
from seoro.bridges.serving.intake import CountedIntake
from seoro.bridges.serving.robot import Handlers, ServedRobot, state_of
from seoro.bridges.serving.work import Work
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, listed

WAITING = Bound(256, lose="newest")  # requests
SETTLED_WITHIN = 1.0  # [s] that goals may take to end before an emergency stop is acknowledged
STOP_DEADLINE = 3.0  # [s] for robots to be stopped at the end
READING = "get_"  # begins what changes nothing
CALLED = "bridge"

SetAlarm: TypeAlias = Callable[[Collection[str], bool], object]
"""Notes that robots are to be stopped in an emergency, or that this was done."""


def no_alarm(_robots: Collection[str], _is_on: bool) -> None:
    """Note nothing: nobody else stops the robots."""


@asynccontextmanager
async def serving(
    door: Door,
    name: str,
    make: Callable[[Work, HappeningLog], Sequence[ServedRobot]],
    state: Path | None = None,
    log: Path | None = None,
    alarm: SetAlarm = no_alarm,
) -> AsyncIterator[RobotServer]:
    """Serve robots for as long as the block lasts; in its end they stand still.

    Args:
        door: Where.
        name: Of the node.
        make: Makes the robots, which tell of goals and watches there.
        state: File in which an emergency stop outlasts the node; None for nowhere.
        log: File of the log of a node with keys.
        alarm: Called, on any thread, when robots are to be stopped in an emergency, and when that was done.

    Raises:
        InvalidUse: The log cannot be written, or there is another node of the name.
    """
    happenings, boot = HappeningLog(), secrets.token_hex(8)
    with opened_gate(door, log) as gate:
        async with background() as reached, background() as tasks:
            work = Work(tasks, happenings)
            server = RobotServer(make(work, happenings), work, happenings, tasks, Latch(state), gate, alarm)
            reached.start_soon(server.watchdog.watch_deadlines)
            try:
                with stop_line(gate.lock, server.stop_at_once, server.keep_stop, door.namespace) as stops:
                    await reached.start(door.attend, partial(_served, server, name, boot, tasks, stops, door))
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
    stops: StopLine,
    door: Door,
    session: AsyncSession,
) -> AsyncIterator[None]:
    """Be the node at a session; `boot` tells this start of it from the next."""
    busy = wire.encode(wire.Refusal(code=wire.LabResult.UNAVAILABLE, message="the node is busy: ask again later"))
    intake = CountedIntake(server.verbs, "node", stop=stops.take)
    key = wire.node_command(wire.NAMESPACE, name, "*")
    server.watchdog.lose_sight()
    async with (
        session.tokens(wire.holder_tokens(wire.NAMESPACE)) as tokens,
        hearing_stops(stops, door, session),
        session.answering(key, WAITING, busy, intake, server.gate.attestor) as requests,
        session.token(wire.node_token(wire.NAMESPACE, name, boot)),
        background() as duties,
    ):
        duties.start_soon(server.watchdog.watch_tokens, tokens)
        duties.start_soon(_answer, server, requests, tasks)
        yield


async def _answer(server: RobotServer, requests: Mailbox[Request], tasks: TaskGroup) -> None:
    async for request in requests:
        tasks.start_soon(server.answer, request)
        await asyncio.sleep(0)  # one at a time, so that nothing else waits for as many as have come at once


class RobotServer:
    """Carries out requests. Made by `serving`.

    Args:
        robots: Who carries them out.
        work: Their goals and watches.
        happenings: What has happened to them.
        tasks: Where robots are stopped whose clients are gone.
        latch: Whether an emergency stop holds.
        gate: Lets requests in.
        alarm: See `serving`.
    """

    def __init__(
        self,
        robots: Sequence[ServedRobot],
        work: Work,
        happenings: HappeningLog,
        tasks: TaskGroup,
        latch: Latch,
        gate: NodeGate,
        alarm: SetAlarm = no_alarm,
    ) -> None:
        self.gate = gate
        self._robots = {robot.info.name: robot for robot in robots}
        self._work = work
        self._happenings = happenings
        self._latch = latch
        self._alarm = alarm
        self._tasks = tasks
        self._loop = asyncio.get_running_loop()
        self._leases = Leases(lambda: self._robots)
        self._ended = ""  # why nothing is done any more
        self._carried: dict[anyio.CancelScope, str] = {}  # what is being carried out, and for which robot
        self.watchdog = Watchdog(self._leases, self._stop_held, tasks)
        own: Handlers = {
            wire.GET_ROBOT_FEATURES: self._features,
            wire.TAKE_ROBOTS: self._take,
            wire.HOLD_ROBOTS: self._hold,
            wire.RELEASE_ROBOTS: self._release,
            wire.STOP_ROBOT: self._stop_robot,
            wire.CANCEL_GOAL: self._cancel,
            wire.CANCEL_WATCH: self._cancel,
            wire.GET_LAB_STATE: self._state,
            wire.LEASE_ROBOTS: self._lease,
            wire.RELEASE_LEASE: self._end_lease,
            wire.RELEASE_STOP: self._release_stop,
        }
        self._own = MappingProxyType({verb.name: (verb, carry) for verb, carry in own.items()})
        self._theirs = {
            name: {verb.name: (verb, carry) for verb, carry in robot.handlers.items()}
            for name, robot in self._robots.items()
        }

    @property
    def verbs(self) -> frozenset[wire.Verb[Any, Any]]:
        """All that can be asked for."""
        served = (verb for named in (self._own, *self._theirs.values()) for verb, _ in named.values())
        return frozenset({wire.CHALLENGE, wire.EMERGENCY_STOP, *served})

    @property
    def _verbs(self) -> frozenset[str]:
        return frozenset({wire.EMERGENCY_STOP.name}).union(self._own, *self._theirs.values())

    async def end(self, reason: str) -> None:
        """Stop all robots, whose goals end as interrupted for a reason, and refuse what is asked for then."""
        self._ended = reason
        await self.stop(reason)

    async def stop(self, reason: str) -> None:
        """Stop all robots, whose goals end as interrupted for a reason."""
        await self._stop_robots(tuple(self._robots), reason)

    async def _stop_held(self, hold: Hold, reason: str) -> None:
        await self._stop_robots(self._leases.robots_of(hold), reason)

    async def _stop_robots(self, names: Collection[str], reason: str) -> None:
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(self._halt, name)
            tasks.start_soon(self._work.interrupt, reason, names)

    async def _halt(self, name: str) -> None:
        """Command zero velocity, after which nothing that was asked for before moves the robot."""
        for scope, robot in self._carried.items():
            if robot == name:
                scope.cancel()
        await self._robots[name].stop()

    async def answer(self, request: Request) -> None:
        """Carry out a request and answer it, whatever happens."""
        await answer(request, partial(self._admit, request), CALLED)

    async def _admit(self, request: Request, name: str, payload: bytes) -> wire.Message:
        if name == wire.CHALLENGE.name:
            return self.gate.prove(payload)
        with self.gate.admitted(request, self._leases.key_of) as sender:
            return await self._carry_out(sender, name, payload)

    async def _carry_out(self, sender: str, name: str, payload: bytes) -> wire.Message:
        if self._ended:
            raise RequestRefused(wire.LabResult.UNAVAILABLE, self._ended)
        if name in self._own:
            verb, carry = self._own[name]
            self.gate.check_holder(name, sender, asked := decoded(verb, payload))
            return await carry(asked)
        serving = {robot: verbs[name] for robot, verbs in self._theirs.items() if name in verbs}
        if not serving:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"robots behind this bridge cannot be asked for {name!r}: known are {listed(self._verbs)}",
            )
        request = decoded(next(iter(serving.values()))[0], payload)
        robot = self._addressed(sender, name, request)
        if not name.startswith(READING):
            self._latch.check(robot)
            self._leases.check(sender, robot, has_to_hold=True)
        if robot not in serving:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"the robot '{robot}' cannot be asked for {name!r}")
        return await self._carry_unless_stopped(robot, serving[robot][1](request))

    async def _carry_unless_stopped(self, robot: str, carried: Awaitable[wire.Message]) -> wire.Message:
        """Carry a request out, which may wait for something, but not beyond a moment when the robot is stopped."""
        with anyio.CancelScope() as scope:
            self._carried[scope] = robot
            try:
                return await carried
            finally:
                del self._carried[scope]
        self._latch.check(robot)
        raise RequestRefused(wire.LabResult.NOT_HELD, f"the robot '{robot}' was stopped")

    def _addressed(self, sender: str, verb: str, request: wire.Message) -> str:
        """The robot that a request is about; without a name, the first that the client has and that can do it."""
        if isinstance(request, wire.WatchProximity) and not request.robot:
            return self._owner(request.frame)
        name: str = getattr(request, "robot", "")
        if not name and verb == wire.CMD_VEL.name:
            hold = self._leases.hold_of(sender)
            able = [robot for robot, verbs in self._theirs.items() if verb in verbs]
            return next((robot for robot in able if hold is not None and hold.has(robot)), able[0])
        self._check(name)
        return name

    def _owner(self, frame: str) -> str:
        """The first robot that has a frame."""
        for name, each in self._robots.items():
            if frame in each.info.frames:
                return name
        known = {known for each in self._robots.values() for known in each.info.frames}
        raise RequestRefused(Result.NOT_FOUND, f"there is no frame '{frame}': known are {listed(known)}")

    def _check(self, robot: str) -> None:
        if robot not in self._robots:
            known = listed(self._robots)
            raise RequestRefused(Result.NOT_FOUND, f"there is no robot '{robot}': there are {known}")

    # -------------------------------------------------------- verbs of all robots

    async def _features(self, _request: wire.Empty) -> wire.RobotFeatures:
        return self._features_of(tuple(self._robots))

    def _features_of(self, names: Sequence[str]) -> wire.RobotFeatures:
        holders = {called(hold.holder): None for name in names if (hold := self._leases.holder_of(name))}
        return wire.RobotFeatures(
            version=__version__,
            features=tuple(sorted(self._verbs)),
            robots=tuple(self._robots[name].info for name in names),
            number=self._happenings.number,
            holder=" and ".join(holders),
        )

    async def _take(self, holder: wire.Holder) -> wire.RobotFeatures:
        self._latch.check(*(holder.robots or self._robots))
        for gone in self._leases.take(holder, self._happenings.now):
            await self._work.forget(own_id(gone.holder.holder, ""))
        hold = self._leases.renew(holder.holder)
        self.watchdog.note()
        return self._features_of(self._leases.robots_of(hold))

    async def _hold(self, request: wire.HoldRobots) -> wire.Happenings:
        hold = self._leases.renew(request.holder)
        self.watchdog.note()
        robots = self._leases.robots_of(hold)
        self._latch.check(*robots)
        happened = await self._happenings.after(request)
        self._latch.check(*robots)
        return share_of(hold, happened)

    async def _release(self, holder: wire.Holder) -> wire.Empty:
        hold = self._leases.hold_of(holder.holder)
        if hold is not None:
            await self._stop_robots(self._leases.robots_of(hold), "the run has ended")
            await self._work.forget(own_id(holder.holder, ""))
        self._leases.release(holder.holder, waits=holder.waits)
        return wire.Empty()

    async def _stop_robot(self, request: wire.StopRobot) -> wire.Empty:
        self._check(request.robot)
        await self._stop_robots({request.robot}, "the robot was stopped")
        return wire.Empty()

    async def _cancel(self, request: wire.CancelGoal | wire.CancelWatch) -> wire.Empty:
        await self._work.cancel(request.id)
        return wire.Empty()

    # -------------------------------------------------------- the lab

    async def _state(self, _request: wire.Empty) -> wire.LabState:
        received, everything = time.time(), self._leases.holder_of_all
        return wire.LabState(
            kind=CALLED,
            version=__version__,
            robots=tuple(
                state_of(robot.info, robot.health, self._leases, self._latch) for robot in self._robots.values()
            ),
            stopped=self._latch.stopped,
            holder="" if everything is None else called(everything.holder),
            received=received,
            sent=time.time(),
        )

    async def _lease(self, request: wire.LeaseRobots) -> wire.Empty:
        self._leases.lease(request)
        return wire.Empty()

    async def _end_lease(self, request: wire.ReleaseLease) -> wire.Empty:
        self._leases.end_lease(request)
        return wire.Empty()

    def stop_at_once(self, asked: wire.EmergencyStop) -> Future[wire.EmergencyStopped]:
        """Let nothing move from now on, or none of the named robots, until that is released; from any thread.

        The event loop then stops what moves. If it is busy, the guard of the bridge has done so.

        Raises:
            RequestRefused: None of the named robots is here.
        """
        names = named_here(asked.robots, self._robots)
        self._latch.stop(asked.model_copy(update={"robots": names if asked.robots else ()}))
        self._alarm(names, True)
        stopped: Future[wire.EmergencyStopped] = Future()
        with suppress(RuntimeError):  # the bridge ends
            self._loop.call_soon_threadsafe(self._tasks.start_soon, self._stop_named, names, stopped)
        return stopped

    def keep_stop(self) -> None:
        """Write down whether an emergency stop holds."""
        self._latch.keep()

    async def _stop_named(self, names: tuple[str, ...], stopped: Future[wire.EmergencyStopped]) -> None:
        try:
            stopped.set_result(await self._stop_in_emergency(names))
        finally:
            self._alarm(names, False)

    async def _stop_in_emergency(self, names: tuple[str, ...]) -> wire.EmergencyStopped:
        began = time.monotonic()
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(self._halt, name)
        took = time.monotonic() - began
        self._happenings.wake()
        over = anyio.Event()
        self._tasks.start_soon(self._abort_goals, names, over)
        with anyio.move_on_after(SETTLED_WITHIN):
            await over.wait()
        return wire.EmergencyStopped(stopped=names, took=took, unsettled=self._work.busy(names))

    async def _abort_goals(self, names: tuple[str, ...], over: anyio.Event) -> None:
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(self._work.interrupt, self._latch.reason_of(name), {name})
        over.set()

    async def _release_stop(self, request: wire.ReleaseStop) -> wire.Empty:
        await anyio.to_thread.run_sync(self._latch.release, request)
        return wire.Empty()
