"""ROS action servers: long-running goals with feedback and cancellation.

An action is three services (`send_goal`, `cancel_goal`, `get_result`) and two topics (`feedback`, `status`) below
`NAME/_action`. Each goal is executed by its own task, which is cancelled with the goal.
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

from seoro.bridges.ros2.geometry import seconds, stamp
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import LATCHED
from seoro.concurrency.background import background
from seoro.errors import SeoroError

log = logging.getLogger(__name__)

KEPT_GOALS = 100  # number of ended goals whose results remain available
ANY = bytes(16)  # goal ID in a request to cancel all goals
UNKNOWN, ENDED = 2, 3  # return codes of rejected requests to cancel (action_msgs/srv/CancelGoal)


class Status(IntEnum):
    """Status of a goal (action_msgs/msg/GoalStatus)."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def is_end(self) -> bool:
        """Whether the status is final."""
        return self >= Status.SUCCEEDED


@dataclass(frozen=True)
class GoalEnd:
    """Final status of a goal, and members of its result message; missing members have their defaults."""

    status: Status
    result: Mapping[str, Any] = field(default_factory=dict)


class GoalHandle:
    """Handle of an accepted goal.

    Args:
        goal_id: ID of the goal: 16 bytes.
        goal: Goal message.
        publish: Publishes feedback messages.

    Attributes:
        accepted: Time of acceptance [s since the epoch].
        status: Present status.
        end: Result, once the goal has ended.
    """

    def __init__(self, goal_id: bytes, goal: Message, publish: Callable[[Mapping[str, Any]], None]) -> None:
        self.goal_id = goal_id
        self.goal: Any = goal
        self.accepted = time.time()
        self.status = Status.ACCEPTED
        self.end: asyncio.Future[GoalEnd] = asyncio.get_running_loop().create_future()
        self._publish = publish
        self._scope = anyio.CancelScope()
        self._stopped = GoalEnd(Status.CANCELED)

    def publish_feedback(self, feedback: Mapping[str, Any]) -> None:
        """Publish feedback."""
        self._publish({"goal_id": {"uuid": self.goal_id}, "feedback": feedback})

    def stop(self, end: GoalEnd) -> None:
        """Cancel the execution of the goal, which then ends with `end`."""
        if not self.status.is_end and not self._scope.cancel_called:
            self._stopped = end
            self._scope.cancel()

    async def run(self, execute: Execute) -> GoalEnd:
        """Execute the goal; called once."""
        end = GoalEnd(Status.ABORTED)
        with self._scope:
            try:
                end = await execute(self)
            except SeoroError as error:
                log.warning("%s", error)
        return self._stopped if self._scope.cancelled_caught else end


Execute = Callable[[GoalHandle], Awaitable[GoalEnd]]
Accept = Callable[[GoalHandle], bool]


@dataclass(eq=False)
class ActionServer:
    """Server of an action. Made by `serving_action`.

    Args:
        accept: Returns whether a goal is accepted. Each accepted goal is executed, though maybe canceled at once.
        execute: Executes a goal; cancelled with the goal. A `SeoroError` aborts the goal.
        feedback: Publisher of feedback.
        tasks: Task group of the goals.
        statuses: Publisher of the goal statuses.
    """

    accept: Accept
    execute: Execute
    feedback: Publication
    tasks: TaskGroup
    statuses: Publication
    _goals: dict[bytes, GoalHandle] = field(default_factory=dict)

    async def on_goal(self, request: Any) -> dict[str, Any]:
        """Accept or reject a goal."""
        goal_id = bytes(request.goal_id.uuid)
        goal = GoalHandle(goal_id, request.goal, self.feedback.publish)
        if goal_id in self._goals or not self.accept(goal):
            return {"accepted": False}
        self._goals[goal_id] = goal
        self._publish()
        self.tasks.start_soon(self._run, goal)
        return {"accepted": True, "stamp": stamp(goal.accepted)}

    async def _run(self, goal: GoalHandle) -> None:
        goal.status = Status.EXECUTING
        self._publish()
        end = await goal.run(self.execute)
        goal.status = end.status
        goal.end.set_result(end)
        self._drop_old_goals()
        self._publish()

    def _drop_old_goals(self) -> None:
        ended = [goal for goal in self._goals.values() if goal.status.is_end]
        for goal in ended[:-KEPT_GOALS]:
            del self._goals[goal.goal_id]

    async def on_result(self, request: Any) -> dict[str, Any]:
        """Wait for the end of a goal; return its result."""
        goal = self._goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            return {"status": Status.UNKNOWN}
        end = await asyncio.shield(goal.end)
        return {"status": end.status, "result": end.result}

    async def on_cancel(self, request: Any) -> dict[str, Any]:
        """Cancel the requested goals: one, those up to a time, or all."""
        goal_id, until = bytes(request.goal_info.goal_id.uuid), seconds(request.goal_info.stamp)
        requested = [
            goal
            for goal in self._goals.values()
            if goal.goal_id == goal_id or (goal.accepted <= until) or (goal_id == ANY and until == 0.0)
        ]
        active = [goal for goal in requested if not goal.status.is_end]
        if goal_id != ANY and not active:
            return {"return_code": ENDED if requested else UNKNOWN}
        for goal in active:
            goal.status = Status.CANCELING
            goal.stop(GoalEnd(Status.CANCELED))
        self._publish()
        return {"goals_canceling": [_info(goal) for goal in active]}

    def _publish(self) -> None:
        statuses = [{"goal_info": _info(goal), "status": goal.status} for goal in self._goals.values()]
        self.statuses.publish({"status_list": statuses})


def _info(goal: GoalHandle) -> dict[str, Any]:
    return {"goal_id": {"uuid": goal.goal_id}, "stamp": stamp(goal.accepted)}


@asynccontextmanager
async def serving_action(
    node: RosNode, name: str, type_name: str, execute: Execute, accept: Accept = lambda _: True
) -> AsyncIterator[None]:
    """Serve an action during the block; goals that are active at its end are cancelled.

    Args:
        node: Node of the server.
        name: Name of the action.
        type_name: Type of the action.
        execute: Executes a goal; see `ActionServer`.
        accept: Returns whether a goal is accepted; see `ActionServer`.

    Raises:
        InvalidName, UnknownInterface: The name or type is invalid.
    """
    kind, below = node.system.types.canonical(type_name), f"{node.resolve(name)}/_action"
    async with (
        node.publishing(f"{below}/feedback", f"{kind}_FeedbackMessage") as feedback,
        node.publishing(f"{below}/status", "action_msgs/msg/GoalStatusArray", LATCHED) as statuses,
        background() as tasks,
    ):
        server = ActionServer(accept, execute, feedback, tasks, statuses)
        async with (
            node.serving(f"{below}/send_goal", f"{kind}_SendGoal", server.on_goal),
            node.serving(f"{below}/get_result", f"{kind}_GetResult", server.on_result),
            node.serving(f"{below}/cancel_goal", "action_msgs/srv/CancelGoal", server.on_cancel),
        ):
            yield
