"""A bridge to a robot on rails, for tests: `python line_robot.py LOG (--listen|--connect) ENDPOINT`.

It drives along the x axis with the last commanded velocity. It writes each new velocity to a file, with the
time of the machine's clock.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import anyio

from seoro.bridges import wire
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.node import serving
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.serving.work import GoalAborted, Work
from seoro.bridges.wire.refusal import RequestRefused, check_drive_duration, check_finite
from seoro.security.network.listener import node_listener

SPEED = 0.5  # [m/s]
TICK = 0.01  # [s]
BATTERY = 0.5


class LineRobot:
    """A robot on rails that starts at x = 0."""

    def __init__(self, name: str, log: Path, work: Work, events: EventLog) -> None:
        self._name = name
        self._log = log
        self._work = work
        self._events = events
        self._x = 0.0
        self._command(0.0)

    @property
    def info(self) -> wire.RobotInfo:
        return wire.RobotInfo(
            name=self._name,
            kinds=("differential_drive_robot", "robot"),
            frames=("map", "base_link", f"{self._name}/base_link"),
        )

    @property
    def health(self) -> wire.RobotHealth:
        return wire.RobotHealth(battery=BATTERY, localised=True, deviation=0.0, position=(self._x, 0.0), seen=0.0)

    @property
    def handlers(self) -> Handlers:
        return {
            wire.SET_INITIAL_POSE: self._set_pose,
            wire.NAVIGATE_THROUGH_POSES: self._navigate,
            wire.DRIVE: self._drive,
            wire.CMD_VEL: self._cmd_vel,
            wire.WATCH_PROXIMITY: self._watch,
            wire.GET_LOCALIZATION: self._localization,
        }

    async def stop(self) -> None:
        self._command(0.0)

    def _command(self, velocity: float) -> None:
        self._velocity = velocity
        with self._log.open("a") as file:
            file.write(f"{time.monotonic()} {self._name} {velocity}\n")

    async def _set_pose(self, request: wire.SetInitialPose) -> wire.Empty:
        self._x = request.pose.position.x
        return wire.Empty()

    async def _navigate(self, request: wire.NavigateThroughPoses) -> wire.Empty:
        targets = [pose.position.x for pose in request.poses]
        if max(targets) > 100.0:
            raise RequestRefused(wire.Result.OPERATION_FAILED, "the rails end at 100 m")
        self._work.start(request.id, partial(self._go, targets), robot=self._name)
        return wire.Empty()

    async def _go(self, targets: Sequence[float]) -> str:
        try:
            for target in targets:
                if target < 0.0:
                    raise GoalAborted("the rails end at 0 m")
                self._command(SPEED)
                while self._x < target:
                    await self._tick()
        finally:
            self._command(0.0)
        return "on rails"

    async def _tick(self) -> None:
        await anyio.sleep(TICK)
        self._x += self._velocity * TICK

    async def _localization(self, _request: wire.RobotName) -> wire.Localization:
        pose = wire.Pose3D(wire.Position3D(x=self._x))
        return wire.Localization(pose=pose, covariance=None, particles=0, error=None)

    async def _drive(self, request: wire.Drive) -> wire.Empty:
        check_finite("velocity", request.linear, request.angular)
        check_drive_duration(request.duration)

        async def drive() -> str:
            try:
                self._command(request.linear)
                with anyio.move_on_after(request.duration):
                    while True:
                        await self._tick()
            finally:
                self._command(0.0)
            return ""

        self._work.start(request.id, drive, robot=self._name)
        return wire.Empty()

    async def _cmd_vel(self, request: wire.CmdVel) -> wire.Empty:
        self._command(request.twist.linear.x)
        return wire.Empty()

    async def _watch(self, request: wire.WatchProximity) -> wire.Empty:
        async def near() -> str:
            while abs(self._x - request.point.x) > request.threshold:
                await anyio.sleep(TICK)
            return ""

        self._work.start(request.id, near)
        return wire.Empty()


async def main(log: str, how: str, endpoint: str, *names: str) -> None:
    """Serve until the process is killed."""

    def make(work: Work, events: EventLog) -> Sequence[LineRobot]:
        return [LineRobot(name, Path(log), work, events) for name in names or ("line",)]

    listener = node_listener(
        endpoint if how == "--listen" else None, endpoint if how == "--connect" else None, "rails"
    )
    async with serving(listener, "rails", make, Path(f"{log}.stop"), Path(f"{log}.jsonl")):
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        await anyio.sleep_forever()


if __name__ == "__main__":
    anyio.run(partial(main, *sys.argv[1:]))
