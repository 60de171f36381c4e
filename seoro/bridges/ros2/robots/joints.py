"""Joints of a robot, from its joint states."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.link import DISCOVERY_TIMEOUT, RobotLink
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_positive, name_list

JOINT_STATES = "sensor_msgs/msg/JointState"
MAX_JOINTS = 1000


@dataclass(frozen=True)
class _Joint:
    """State of a joint: its position [rad, m], velocity [rad/s, m/s] and effort [N m, N].

    Controllers publish a position that is not finite until they have read the hardware.
    """

    position: float = math.nan
    velocity: float = 0.0
    effort: float = 0.0


class Joints:
    """Joints of a robot.

    Args:
        link: Link to the robot.
        topic: Topic of the joint states.
        names: Names of the joints of its arm and gripper, in order.
    """

    def __init__(self, link: RobotLink, topic: str, names: Sequence[str]) -> None:
        self._link = link
        self._topic = topic
        self._names = tuple(names)
        self._states: dict[str, _Joint] = {}

    @property
    def handlers(self) -> Handlers:
        """Handlers of the served verbs."""
        return {wire.GET_JOINT_STATES: self._get, wire.WATCH_JOINT: self._watch}

    async def open(self) -> None:
        """Subscribe to the joint states."""
        await self._link.listen(self._topic, JOINT_STATES, self._on_states, forget=self._forget)

    def _forget(self) -> None:
        """Forget all states: their publisher has disappeared, and may restart."""
        self._states.clear()

    def _on_states(self, message: Message) -> None:
        columns = {column: getattr(message, column) for column in ("position", "velocity", "effort")}
        valid = {column: values for column, values in columns.items() if len(values) == len(message.name)}
        for index, name in enumerate(message.name):
            if name in self._states or len(self._states) < MAX_JOINTS:
                changes = {column: float(values[index]) for column, values in valid.items()}
                # Joints that a message leaves out keep their states.
                self._states[name] = replace(self._states.get(name, _Joint()), **changes)

    async def position(self, joint: str) -> float:
        """Return the position of a joint [rad, m]; wait a while for a message.

        Raises:
            RequestRefused: The position is unknown.
        """
        return (await self._state(joint)).position

    async def _state(self, joint: str) -> _Joint:
        """Return the state of a joint with a known position; wait a while for a message."""
        with anyio.move_on_after(DISCOVERY_TIMEOUT):
            await self._link.intake.arrivals.wait_for(lambda: self._has_position(joint))
        if self._has_position(joint):
            return self._states[joint]
        raise RequestRefused(Result.NOT_FOUND, self._explain_unknown(joint))

    def _has_position(self, joint: str) -> bool:
        return joint in self._states and math.isfinite(self._states[joint].position)

    def _explain_unknown(self, joint: str) -> str:
        topic = self._link.node.resolve(self._topic)
        if joint in self._states:
            return f"the position of the joint '{joint}' on {topic} is not finite: is the hardware active?"
        known = f"joints: {name_list(self._states)}" if self._states else self._link.explain_silence(self._topic)
        return f"no state of the joint '{joint}' on {topic} ({known})"

    async def _get(self, _request: wire.RobotName) -> wire.JointStates:
        states = [await self._state(name) for name in self._names]
        return wire.JointStates(
            names=self._names,
            positions=tuple(state.position for state in states),
            velocities=tuple(state.velocity for state in states),
            efforts=tuple(state.effort for state in states),
        )

    async def _watch(self, request: wire.WatchJoint) -> None:
        check_finite("position", request.position)
        check_positive("tolerance", request.tolerance)
        start = await self.position(request.joint)
        self._link.work.start(request.id, partial(self._wait_reached, request, start))

    async def _wait_reached(self, request: wire.WatchJoint, start: float) -> str:
        side = math.copysign(1.0, start - request.position)

        def is_reached() -> bool:
            nonlocal side
            if not self._has_position(request.joint):
                side = 0.0  # the joint may be on the other side afterwards, without a motion past the position
                return False
            difference = self._states[request.joint].position - request.position
            side = side or math.copysign(1.0, difference)
            return abs(difference) <= request.tolerance or math.copysign(1.0, difference) != side

        await self._link.intake.arrivals.wait_for(is_reached)
        return ""
