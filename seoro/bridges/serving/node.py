"""A node that serves robots: verbs to robots, one holder, and robots that stop when that is gone."""

from __future__ import annotations

import secrets
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from types import MappingProxyType

import anyio
from anyio.abc import TaskGroup

from seoro import __version__
from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.serving.answering import answer, decoded
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.hold import Hold
from seoro.bridges.serving.robot import Handlers, ServedRobot
from seoro.bridges.serving.work import Work
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, listed

WAITING = Bound(256, lose="newest")  # requests
STOP_DEADLINE = 3.0  # [s] for robots to be stopped at the end
# What may be asked while nobody holds the robots.
HARMLESS = frozenset({wire.STOP_ROBOT.name, wire.CANCEL_GOAL.name, wire.CANCEL_WATCH.name})


@dataclass(frozen=True)
class NodeAt:
    """Where a node is: a session, its namespace and its name."""

    session: AsyncSession
    namespace: str
    name: str


@asynccontextmanager
async def serving(
    at: NodeAt, make: Callable[[Work, HappeningLog], Sequence[ServedRobot]]
) -> AsyncIterator[RobotServer]:
    """Serve robots for as long as the block lasts; in its end they stand still.

    Args:
        at: Where.
        make: Makes the robots, which tell of goals and watches there.
    """
    busy = wire.encode(wire.Refusal(code=Result.OPERATION_FAILED, message="the node is busy: ask again later"))
    session, happenings = at.session, HappeningLog()
    async with background() as tasks:
        work = Work(tasks, happenings)
        server = RobotServer(make(work, happenings), work, happenings)
        try:
            async with (
                session.tokens(wire.holder_tokens(at.namespace)) as tokens,
                session.answering(wire.node_command(at.namespace, at.name, "*"), WAITING, busy) as requests,
                session.token(wire.node_token(at.namespace, at.name, secrets.token_hex(8))),
                background() as duties,
            ):
                duties.start_soon(server.hold.watch_deadline)
                duties.start_soon(server.hold.watch_tokens, tokens, at.namespace)
                duties.start_soon(_answer, server, requests, tasks)
                yield server
        finally:
            with anyio.move_on_after(STOP_DEADLINE, shield=True):
                await server.stop("the bridge ends")


async def _answer(server: RobotServer, requests: Mailbox[Request], tasks: TaskGroup) -> None:
    async for request in requests:
        tasks.start_soon(server.answer, request)


class RobotServer:
    """Carries out requests. Made by `serving`.

    Args:
        robots: Who carries them out.
        work: Their goals and watches.
        happenings: What has happened to them.
    """

    def __init__(self, robots: Sequence[ServedRobot], work: Work, happenings: HappeningLog) -> None:
        self._robots = {robot.info.name: robot for robot in robots}
        self._work = work
        self._happenings = happenings
        self.hold = Hold(self.stop)
        own: Handlers = {
            wire.GET_ROBOT_FEATURES: self._features,
            wire.TAKE_ROBOTS: self._take,
            wire.HOLD_ROBOTS: self._hold,
            wire.RELEASE_ROBOTS: self._release,
            wire.STOP_ROBOT: self._stop_robot,
            wire.CANCEL_GOAL: self._cancel,
            wire.CANCEL_WATCH: self._cancel,
        }
        self._own = MappingProxyType({verb.name: (verb, carry) for verb, carry in own.items()})
        self._theirs = {
            name: {verb.name: (verb, carry) for verb, carry in robot.handlers.items()}
            for name, robot in self._robots.items()
        }

    @property
    def _verbs(self) -> frozenset[str]:
        return frozenset(self._own).union(*self._theirs.values())

    async def stop(self, reason: str) -> None:
        """Stop all robots; their goals end as aborted for a reason."""
        async with anyio.create_task_group() as tasks:
            for robot in self._robots.values():
                tasks.start_soon(robot.stop)
            tasks.start_soon(self._work.abort, reason)

    async def answer(self, request: Request) -> None:
        """Carry out a request and answer it, whatever happens."""
        await answer(request, self._carry_out, "bridge")

    async def _carry_out(self, name: str, payload: bytes) -> wire.Message:
        if name not in HARMLESS and name not in {verb.name for verb in wire.BRIDGE_VERBS}:
            self.hold.check()
        if name in self._own:
            verb, carry = self._own[name]
            return await carry(decoded(verb, payload))
        serving = {robot: verbs[name] for robot, verbs in self._theirs.items() if name in verbs}
        if not serving:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"robots behind this bridge cannot be asked for {name!r}: known are {listed(self._verbs)}",
            )
        request = decoded(next(iter(serving.values()))[0], payload)
        robot = self._addressed(name, request)
        if robot not in serving:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"the robot '{robot}' cannot be asked for {name!r}")
        return await serving[robot][1](request)

    def _addressed(self, verb: str, request: wire.Message) -> str:
        """The robot that a request is about."""
        if isinstance(request, wire.WatchProximity) and not request.robot:
            return self._owner(request.frame)
        name: str = getattr(request, "robot", "")
        if not name and verb == wire.CMD_VEL.name:
            return next(robot for robot, verbs in self._theirs.items() if verb in verbs)
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
            raise RequestRefused(
                Result.NOT_FOUND, f"there is no robot '{robot}': there are {listed(self._robots)}"
            )

    # -------------------------------------------------------- verbs of all robots

    async def _features(self, _request: wire.Empty) -> wire.RobotFeatures:
        holder = self.hold.holder
        return wire.RobotFeatures(
            version=__version__,
            features=tuple(sorted(self._verbs)),
            robots=tuple(robot.info for robot in self._robots.values()),
            number=self._happenings.number,
            holder="" if holder is None else holder.purpose or holder.holder,
        )

    async def _take(self, holder: wire.Holder) -> wire.RobotFeatures:
        self.hold.take(holder)
        await self._work.forget()  # of a holder that is gone
        self.hold.renew(holder.holder)
        self._happenings.begin()
        return await self._features(wire.Empty())

    async def _hold(self, request: wire.HoldRobots) -> wire.Happenings:
        self.hold.renew(request.holder)
        return await self._happenings.after(request)

    async def _release(self, holder: wire.Holder) -> wire.Empty:
        if self.hold.is_of(holder.holder):
            await self.stop("the run has ended")
            await self._work.forget()
            self.hold.release()
        return wire.Empty()

    async def _stop_robot(self, request: wire.StopRobot) -> wire.Empty:
        self._check(request.robot)
        await self._robots[request.robot].stop()
        await self._work.abort("the robot was stopped", request.robot)
        return wire.Empty()

    async def _cancel(self, request: wire.CancelGoal | wire.CancelWatch) -> wire.Empty:
        await self._work.cancel(request.id)
        return wire.Empty()
