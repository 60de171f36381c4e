"""Robots that are stopped while something that was asked for before is still being carried out."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import Future

import anyio
import pytest

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.leasing.latch import Latch
from seoro.bridges.serving.gate import NodeGate
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.node import RobotServer
from seoro.bridges.serving.robot import Handlers, Health
from seoro.bridges.serving.work import Work
from seoro.bridges.wire.refusal import RequestRefused

pytestmark = pytest.mark.anyio


class SlowRobot:
    """A robot that takes a moment from a request to its motion."""

    def __init__(self, work: Work) -> None:
        self._work = work
        self.asked, self.ready = anyio.Event(), anyio.Event()
        self.velocity = 0.0
        self.health = Health()

    @property
    def info(self) -> wire.RobotInfo:
        return wire.RobotInfo(name="slow", kinds=("robot",), frames=())

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

        self._work.start(request.id, drive, robot="slow")
        return wire.Empty()


async def ask(server: RobotServer, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> wire.Message:
    return await server._carry_out("a run", verb.name, wire.encode(request))


async def test_what_was_asked_for_before_a_stop_moves_nothing_after_it() -> None:
    async with background() as tasks:
        happenings = HappeningLog()
        work = Work(tasks, happenings)
        robot = SlowRobot(work)
        server = RobotServer([robot], work, happenings, tasks, Latch(), NodeGate())
        await ask(server, wire.TAKE_ROBOTS, wire.Holder(holder="a run"))
        refused: list[RequestRefused] = []

        async def command() -> None:
            twist = wire.Twist(linear=wire.Vector3(x=1.0), angular=wire.Vector3())
            try:
                await ask(server, wire.CMD_VEL, wire.CmdVel(robot="slow", twist=twist))
            except RequestRefused as error:
                refused.append(error)

        async with anyio.create_task_group() as commands:
            commands.start_soon(command)
            await robot.asked.wait()
            await asyncio.wrap_future(server.stop_at_once(wire.EmergencyStop(by="ana", reason="smoke")))
            robot.ready.set()
        assert robot.velocity == 0.0
        assert "emergency stop by ana" in refused[0].message


async def test_goals_that_do_not_end_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.serving.node.SETTLED_WITHIN", 0.05)
    async with background() as tasks:
        happenings = HappeningLog()
        work = Work(tasks, happenings)
        robot = SlowRobot(work)
        server = RobotServer([robot], work, happenings, tasks, Latch(), NodeGate())
        await ask(server, wire.TAKE_ROBOTS, wire.Holder(holder="a run"))
        drive = wire.Drive(id="a run.goal-1", robot="slow", linear=1.0, angular=0.0, duration=1.0)
        await ask(server, wire.DRIVE, drive)
        await anyio.sleep(0)

        async def stop() -> wire.EmergencyStopped:
            return await asyncio.wrap_future(server.stop_at_once(wire.EmergencyStop(by="ana")))

        told = await stop()
        assert told.unsettled == ("slow",)
        robot.ready.set()
        for change, unsettled in ((None, ()), (work.doubt, ("slow",)), (work.settle, ())):
            if change is not None:
                change("slow")
            told = await stop()
            assert told.unsettled == unsettled


async def test_a_stop_takes_effect_while_the_event_loop_is_busy() -> None:
    async with background() as tasks:
        happenings = HappeningLog()
        work = Work(tasks, happenings)
        latch, alarms, told = Latch(), list[bool](), threading.Event()

        def alarm(is_on: bool) -> None:
            alarms.append(is_on)
            told.set()

        server = RobotServer([SlowRobot(work)], work, happenings, tasks, latch, NodeGate(), alarm)
        stops: list[Future[wire.EmergencyStopped]] = []
        thread = threading.Thread(target=lambda: stops.append(server.stop_at_once(wire.EmergencyStop(by="ana"))))
        thread.start()
        assert told.wait(5.0)  # in which the event loop does nothing else
        thread.join()
        assert latch.stopped is not None
        assert (alarms, stops[0].done()) == ([True], False)
        assert (await asyncio.wrap_future(stops[0])).stopped == ("slow",)
        await anyio.sleep(0)
        assert alarms == [True, False]
