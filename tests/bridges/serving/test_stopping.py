"""Stops of robots during earlier requests."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Collection
from concurrent.futures import Future

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.leasing.emergency_stop import EmergencyStopState
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.node import RobotServer
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.serving.work import Work
from seoro.bridges.wire.refusal import RequestRefused
from seoro.concurrency.background import background
from seoro.security.network.authorizer import NodeAuthorizer

pytestmark = pytest.mark.anyio


class SlowRobot:
    """A robot that delays the motion of a request."""

    def __init__(self, work: Work, name: str = "slow") -> None:
        self._work = work
        self.name = name
        self.asked, self.ready = anyio.Event(), anyio.Event()
        self.velocity = 0.0
        self.health = wire.RobotHealth()

    @property
    def info(self) -> wire.RobotInfo:
        return wire.RobotInfo(name=self.name, kinds=("robot",), frames=())

    @property
    def handlers(self) -> Handlers:
        return {wire.CMD_VEL: self._command, wire.DRIVE: self._drive}

    async def stop(self) -> None:
        self.velocity = 0.0

    async def _command(self, request: wire.CmdVel) -> wire.Empty:
        self.asked.set()
        await self.ready.wait()
        self.velocity = request.twist.linear.x
        return wire.Empty()

    async def _drive(self, request: wire.Drive) -> wire.Empty:
        async def drive() -> str:
            with anyio.CancelScope(shield=True):
                await self.ready.wait()
            return ""

        self._work.start(request.id, drive, robot=self.name)
        return wire.Empty()


async def ask(
    server: RobotServer, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, sender: str = "a run"
) -> wire.Message | None:
    return await server._carry_out(sender, verb.name, wire.encode(request))


def forward(robot: str) -> wire.CmdVel:
    return wire.CmdVel(robot=robot, twist=wire.Twist(linear=wire.Vector3(x=1.0), angular=wire.Vector3()))


async def test_commands_from_before_a_stop_move_no_robot_after_it() -> None:
    async with background() as tasks:
        events = EventLog()
        work = Work(tasks, events)
        robot = SlowRobot(work)
        server = RobotServer([robot], work, events, tasks, EmergencyStopState(), NodeAuthorizer())
        await ask(server, wire.TAKE_ROBOTS, wire.Holder(holder="a run"))
        refused: list[RequestRefused] = []

        async def command() -> None:
            try:
                await ask(server, wire.CMD_VEL, forward("slow"))
            except RequestRefused as error:
                refused.append(error)

        async with anyio.create_task_group() as commands:
            commands.start_soon(command)
            await robot.asked.wait()
            await asyncio.wrap_future(server.stop_at_once(wire.EmergencyStop(by="ana", reason="smoke")))
            robot.ready.set()
        assert robot.velocity == 0.0
        assert "emergency stop by ana" in refused[0].message


async def test_goals_that_do_not_end_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.serving.node.SETTLED_WITHIN", 0.05)
    async with background() as tasks:
        events = EventLog()
        work = Work(tasks, events)
        robot = SlowRobot(work)
        server = RobotServer([robot], work, events, tasks, EmergencyStopState(), NodeAuthorizer())
        await ask(server, wire.TAKE_ROBOTS, wire.Holder(holder="a run"))
        drive = wire.Drive(id="a run.goal-1", robot="slow", linear=1.0, angular=0.0, duration=1.0)
        await ask(server, wire.DRIVE, drive)
        await anyio.sleep(0)

        async def stop() -> wire.StopAcknowledgement:
            return await asyncio.wrap_future(server.stop_at_once(wire.EmergencyStop(by="ana")))

        reported = await stop()
        assert reported.unsettled == ("slow",)
        robot.ready.set()
        for change, unsettled in ((None, ()), (work.mark_unsettled, ("slow",)), (work.mark_settled, ())):
            if change is not None:
                change("slow")
            reported = await stop()
            assert reported.unsettled == unsettled


async def test_a_stop_takes_effect_while_the_event_loop_is_busy() -> None:
    async with background() as tasks:
        events = EventLog()
        work = Work(tasks, events)
        latch, alarms, reported = EmergencyStopState(), list[tuple[tuple[str, ...], bool]](), threading.Event()

        def alarm(robots: Collection[str], is_on: bool) -> None:
            alarms.append((tuple(robots), is_on))
            reported.set()

        server = RobotServer([SlowRobot(work)], work, events, tasks, latch, NodeAuthorizer(), alarm)
        stops: list[Future[wire.StopAcknowledgement]] = []
        thread = threading.Thread(target=lambda: stops.append(server.stop_at_once(wire.EmergencyStop(by="ana"))))
        thread.start()
        assert reported.wait(30.0)  # blocks the event loop
        thread.join()
        assert latch.stopped is not None
        assert (alarms, stops[0].done()) == ([(("slow",), True)], False)
        assert (await asyncio.wrap_future(stops[0])).stopped == ("slow",)
        await anyio.sleep(0)
        assert alarms == [(("slow",), True), (("slow",), False)]


async def test_a_stop_of_named_robots_leaves_others_running() -> None:
    async with background() as tasks:
        events = EventLog()
        work = Work(tasks, events)
        robots = [SlowRobot(work, name) for name in ("slow", "other")]
        for robot in robots:
            robot.ready.set()
        alarms: list[tuple[tuple[str, ...], bool]] = []

        def alarm(names: Collection[str], is_on: bool) -> None:
            alarms.append((tuple(names), is_on))

        server = RobotServer(robots, work, events, tasks, EmergencyStopState(), NodeAuthorizer(), alarm)
        for robot in robots:
            await ask(server, wire.TAKE_ROBOTS, wire.Holder(holder=robot.name, robots=(robot.name,)), robot.name)
            await ask(server, wire.CMD_VEL, forward(robot.name), robot.name)
        stop = wire.EmergencyStop(by="ana", reason="smoke", robots=("slow", "elsewhere"))
        reported = await asyncio.wrap_future(server.stop_at_once(stop))
        await anyio.sleep(0)
        assert reported.stopped == ("slow",)
        assert alarms == [(("slow",), True), (("slow",), False)]
        assert [robot.velocity for robot in robots] == [0.0, 1.0]
        does_not_move = "the robot 'slow' may not move: emergency stop by ana"
        with pytest.raises(RequestRefused, match=does_not_move):
            await ask(server, wire.CMD_VEL, forward("slow"), "slow")
        with pytest.raises(RequestRefused, match=does_not_move):
            await ask(server, wire.HOLD_ROBOTS, wire.HoldRobots(holder="slow", since=0), "slow")
        await ask(server, wire.RELEASE_ROBOTS, wire.Holder(holder="slow"), "slow")
        for wanted in (("slow",), ()):
            with pytest.raises(RequestRefused, match=does_not_move):
                await ask(server, wire.TAKE_ROBOTS, wire.Holder(holder="a run", robots=wanted), "a run")
        await ask(server, wire.CMD_VEL, forward("other"), "other")
        state = await ask(server, wire.GET_LAB_STATE, wire.Empty())
        assert isinstance(state, wire.LabState)
        assert state.stopped is None
        assert [None if each.stopped is None else each.stopped.by for each in state.robots] == ["ana", None]
        release = wire.ReleaseStop(by="bob", reason="toast", robots=("slow",))
        await ask(server, wire.RELEASE_STOP, release)
        await ask(server, wire.TAKE_ROBOTS, wire.Holder(holder="a run", robots=("slow",)), "a run")


async def test_a_stop_of_unknown_robots_stops_nothing() -> None:
    async with background() as tasks:
        events = EventLog()
        work = Work(tasks, events)
        latch = EmergencyStopState()
        server = RobotServer([SlowRobot(work)], work, events, tasks, latch, NodeAuthorizer())
        with pytest.raises(RequestRefused, match=r"unknown robots: elsewhere \(robots here: slow\)"):
            server.stop_at_once(wire.EmergencyStop(by="ana", robots=("elsewhere",)))
        assert latch.stopped is None
        assert not latch.robots
