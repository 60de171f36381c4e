"""Where the joints of a robot are, as it says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.link import FOUND_WITHIN, Link
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.serving.work import Work
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_positive, listed
from seoro.changes import Changes

MOST = 1000  # joints of a robot


class Joints:
    """The joints of a robot.

    Args:
        link: To the robot.
        topic: On which it says where they are.
        names: Those of its arm and gripper, in order.
        work: Where watches run.
    """

    def __init__(self, link: Link, topic: str, names: Sequence[str], work: Work) -> None:
        self._link = link
        self._topic = topic
        self._names = tuple(names)
        self._work = work
        self._states: dict[str, tuple[float, float, float]] = {}  # position, velocity, effort
        self._changes = Changes()

    @property
    def handlers(self) -> Handlers:
        """The verbs that are served."""
        return {wire.GET_JOINT_STATES: self._get, wire.WATCH_JOINT: self._watch}

    async def open(self) -> None:
        """Listen to what it says."""
        await self._link.listen(self._topic, "sensor_msgs/msg/JointState", self._take)
        self._link.tasks.start_soon(self._link.watch_end, self._topic, self._forget)

    def _forget(self) -> None:
        """Forget where they were: whoever said so is gone, and may start anew."""
        self._states.clear()
        self._changes.tell()

    def _take(self, message: Message) -> None:
        count = len(message.name)
        columns = [
            list(each) if len(each) == count else [0.0] * count
            for each in (message.position, message.velocity, message.effort)
        ]
        for name, *state in zip(message.name, *columns, strict=True):
            if name in self._states or len(self._states) < MOST:
                self._states[name] = (float(state[0]), float(state[1]), float(state[2]))
        self._changes.tell()

    async def position(self, joint: str) -> float:
        """Where a joint is [rad, m]; waits a while for the robot to say so.

        Raises:
            RequestRefused: It does not.
        """
        return (await self._state(joint))[0]

    async def _state(self, joint: str) -> tuple[float, float, float]:
        """Position, velocity and effort of a joint; waits a while for the robot to say them."""
        with anyio.move_on_after(FOUND_WITHIN):
            await self._changes.wait_for(lambda: joint in self._states)
        if joint not in self._states:
            topic = self._link.node.resolve(self._topic)
            why = f"it tells of {listed(self._states)}" if self._states else self._link.why_silent(self._topic)
            raise RequestRefused(
                Result.NOT_FOUND, f"the robot says nothing of a joint '{joint}' on {topic}: {why}"
            )
        return self._states[joint]

    async def _get(self, _request: wire.RobotName) -> wire.JointStates:
        states = [await self._state(name) for name in self._names]
        positions, velocities, efforts = zip(*states, strict=True)
        return wire.JointStates(names=self._names, positions=positions, velocities=velocities, efforts=efforts)

    async def _watch(self, request: wire.WatchJoint) -> wire.Empty:
        check_finite("position", request.position)
        check_positive("tolerance", request.tolerance)
        began = await self.position(request.joint)
        self._work.start(request.id, partial(self._come_to, request, began))
        return wire.Empty()

    async def _come_to(self, request: wire.WatchJoint, began: float) -> str:
        side = math.copysign(1.0, began - request.position)

        def is_there() -> bool:
            nonlocal side
            if request.joint not in self._states:
                side = 0.0  # where it begins anew, it has not come from here
                return False
            off = self._states[request.joint][0] - request.position
            side = side or math.copysign(1.0, off)
            return abs(off) <= request.tolerance or math.copysign(1.0, off) != side

        await self._changes.wait_for(is_there)
        return ""
