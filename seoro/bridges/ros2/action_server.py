"""Serving ROS actions: goals that take a while, tell how far they are, and can be called off.

An action is three services (`send_goal`, `cancel_goal`, `get_result`) and two topics (`feedback`, `status`) below
`NAME/_action`. Each goal is carried out by a task of its own, which is cancelled when the goal is.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import anyio
from anyio.abc import TaskGroup

from seoro.background import background
from seoro.bridges.ros2.geometry import seconds, stamp
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.errors import SeoroError

log = logging.getLogger(__name__)

KEPT = 100  # goals that have ended, whose results can still be asked for
ANY = bytes(16)  # in a request to cancel: not one goal, but all
UNKNOWN, ENDED = 2, 3  # why nothing is cancelled (action_msgs/srv/CancelGoal)


class Status(IntEnum):
    """Of a goal (action_msgs/msg/GoalStatus)."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def is_end(self) -> bool:
        """Whether nothing comes after it."""
        return self >= Status.SUCCEEDED


@dataclass(frozen=True)
class GoalEnd:
    """How a goal has ended: its status, and the members of its result; missing ones have their defaults."""

    status: Status
    result: Mapping[str, Any] = field(default_factory=dict)


class ServedGoal:
    """A goal that was accepted.

    Args:
        number: The 16 bytes that it is known by.
        goal: What is to be reached.
        told: Publishes feedback.

    Attributes:
        accepted: When it was [s since the epoch].
        status: How far it is.
        end: How it has ended, when it has.
    """

    def __init__(self, number: bytes, goal: Message, told: Callable[[Mapping[str, Any]], None]) -> None:
        self.number = number
        self.goal: Any = goal
        self.accepted = time.time()
        self.status = Status.ACCEPTED
        self.end: asyncio.Future[GoalEnd] = asyncio.get_running_loop().create_future()
        self._told = told
        self._scope = anyio.CancelScope()
        self._stopped = GoalEnd(Status.CANCELED)

    def tell(self, feedback: Mapping[str, Any]) -> None:
        """Publish feedback."""
        self._told({"goal_id": {"uuid": list(self.number)}, "feedback": feedback})

    def stop(self, end: GoalEnd) -> None:
        """Have it end in this way, as soon as what carries it out has been cancelled."""
        if not self.status.is_end and not self._scope.cancel_called:
            self._stopped = end
            self._scope.cancel()

    async def carry_out(self, carry_out: Carry) -> GoalEnd:
        """Carry it out; called once."""
        end = GoalEnd(Status.ABORTED)
        with self._scope:
            try:
                end = await carry_out(self)
            except SeoroError as error:
                log.warning("%s", error)
        return self._stopped if self._scope.cancelled_caught else end


Carry = Callable[[ServedGoal], Awaitable[GoalEnd]]
Accept = Callable[[ServedGoal], bool]


class ActionServer:
    """What serves an action. Made by `serving_action`.

    Args:
        accept: Says whether a goal is taken. Whatever it takes is carried out, though maybe cancelled before.
        carry_out: Carries a goal out. It is cancelled when the goal is; what it raises of seoro's errors aborts
            the goal.
        told: Publishes feedback.
        tasks: Those of the server.
        statuses: The topic of what goals there are.
    """

    def __init__(
        self,
        accept: Accept,
        carry_out: Carry,
        told: Callable[[Mapping[str, Any]], None],
        tasks: TaskGroup,
        statuses: Publication,
    ) -> None:
        self._accept = accept
        self._carry_out = carry_out
        self._told = told
        self._tasks = tasks
        self._statuses = statuses
        self._goals: dict[bytes, ServedGoal] = {}

    async def send(self, request: Any) -> dict[str, Any]:
        """Take a goal, or not."""
        number = bytes(request.goal_id.uuid)
        goal = ServedGoal(number, request.goal, self._told)
        if number in self._goals or not self._accept(goal):
            return {"accepted": False}
        self._goals[number] = goal
        self._publish()
        self._tasks.start_soon(self._run, goal)
        return {"accepted": True, "stamp": stamp(goal.accepted)}

    async def _run(self, goal: ServedGoal) -> None:
        goal.status = Status.EXECUTING
        self._publish()
        end = await goal.carry_out(self._carry_out)
        goal.status = end.status
        goal.end.set_result(end)
        self._forget_some()
        self._publish()

    def _forget_some(self) -> None:
        ended = [goal for goal in self._goals.values() if goal.status.is_end]
        for goal in ended[:-KEPT]:
            del self._goals[goal.number]

    async def result(self, request: Any) -> dict[str, Any]:
        """Wait for the end of a goal, and say how it was."""
        goal = self._goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            return {"status": Status.UNKNOWN}
        end = await asyncio.shield(goal.end)
        return {"status": end.status, "result": end.result}

    async def cancel(self, request: Any) -> dict[str, Any]:
        """Call off the goals that are meant: one, those up to a time, or all."""
        number, until = bytes(request.goal_info.goal_id.uuid), seconds(request.goal_info.stamp)
        meant = [
            goal
            for goal in self._goals.values()
            if goal.number == number or (goal.accepted <= until) or (number == ANY and until == 0.0)
        ]
        going = [goal for goal in meant if not goal.status.is_end]
        if number != ANY and not going:
            return {"return_code": ENDED if meant else UNKNOWN}
        for goal in going:
            goal.status = Status.CANCELING
            goal.stop(GoalEnd(Status.CANCELED))
        self._publish()
        return {"goals_canceling": [_info(goal) for goal in going]}

    def _publish(self) -> None:
        statuses = [{"goal_info": _info(goal), "status": goal.status} for goal in self._goals.values()]
        self._statuses.publish({"status_list": statuses})


def _info(goal: ServedGoal) -> dict[str, Any]:
    return {"goal_id": {"uuid": list(goal.number)}, "stamp": stamp(goal.accepted)}


@asynccontextmanager
async def serving_action(
    node: RosNode, name: str, type_name: str, carry_out: Carry, accept: Accept = lambda _: True
) -> AsyncIterator[None]:
    """Serve an action for as long as the block lasts; goals that go on then are cancelled.

    Args:
        node: Who serves it.
        name: Its name.
        type_name: Its type.
        carry_out: Carries a goal out; see `ActionServer`.
        accept: Says whether a goal is taken; see `ActionServer`.

    Raises:
        InvalidName, UnknownInterface: There is no such name or type.
    """
    kind, below = node.system.types.canonical(type_name), f"{node.resolve(name)}/_action"
    latched = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
    async with (
        node.publishing(f"{below}/feedback", f"{kind}_FeedbackMessage") as feedback,
        node.publishing(f"{below}/status", "action_msgs/msg/GoalStatusArray", latched) as statuses,
        background() as tasks,
    ):
        server = ActionServer(accept, carry_out, feedback.publish, tasks, statuses)
        async with (
            node.serving(f"{below}/send_goal", f"{kind}_SendGoal", server.send),
            node.serving(f"{below}/get_result", f"{kind}_GetResult", server.result),
            node.serving(f"{below}/cancel_goal", "action_msgs/srv/CancelGoal", server.cancel),
        ):
            yield
