"""Where the joints of a robot are, as it says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
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


@dataclass(frozen=True)
class _Joint:
    """What is known of a joint: its position [rad, m], velocity [rad/s, m/s] and effort [N m, N].

    A position that is no finite number is what controllers tell while they have not read the hardware.
    """

    position: float = math.nan
    velocity: float = 0.0
    effort: float = 0.0


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
        self._states: dict[str, _Joint] = {}
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
        columns = {column: getattr(message, column) for column in ("position", "velocity", "effort")}
        told = {column: values for column, values in columns.items() if len(values) == len(message.name)}
        for index, name in enumerate(message.name):
            if name in self._states or len(self._states) < MOST:
                news = {column: float(values[index]) for column, values in told.items()}
                # What a message leaves out is as it was.
                self._states[name] = replace(self._states.get(name, _Joint()), **news)
        self._changes.tell()

    async def position(self, joint: str) -> float:
        """Where a joint is [rad, m]; waits a while for the robot to say so.

        Raises:
            RequestRefused: It does not.
        """
        return (await self._state(joint)).position

    async def _state(self, joint: str) -> _Joint:
        """What is known of a joint that is somewhere; waits a while for the robot to say where."""
        with anyio.move_on_after(FOUND_WITHIN):
            await self._changes.wait_for(lambda: self._is_somewhere(joint))
        if self._is_somewhere(joint):
            return self._states[joint]
        raise RequestRefused(Result.NOT_FOUND, self._why_nowhere(joint))

    def _is_somewhere(self, joint: str) -> bool:
        return joint in self._states and math.isfinite(self._states[joint].position)

    def _why_nowhere(self, joint: str) -> str:
        topic = self._link.node.resolve(self._topic)
        if joint in self._states:
            told = f"the robot tells no position of the joint '{joint}' on {topic} that is a finite number"
            return f"{told}: is its hardware active?"
        why = f"it tells of {listed(self._states)}" if self._states else self._link.why_silent(self._topic)
        return f"the robot says nothing of a joint '{joint}' on {topic}: {why}"

    async def _get(self, _request: wire.RobotName) -> wire.JointStates:
        states = [await self._state(name) for name in self._names]
        return wire.JointStates(
            names=self._names,
            positions=tuple(state.position for state in states),
            velocities=tuple(state.velocity for state in states),
            efforts=tuple(state.effort for state in states),
        )

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
            if not self._is_somewhere(request.joint):
                side = 0.0  # where it begins anew, it has not come from here
                return False
            off = self._states[request.joint].position - request.position
            side = side or math.copysign(1.0, off)
            return abs(off) <= request.tolerance or math.copysign(1.0, off) != side

        await self._changes.wait_for(is_there)
        return ""
