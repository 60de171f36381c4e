"""Goals of actions of a robot: their server, and the time of sending."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.clients.cancellation import CANCEL_GOAL
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.robots.guard_state import GuardState
from seoro.bridges.ros2.robots.link import RobotLink
from seoro.bridges.ros2.robots.pursuit import ActionGoal, pursue
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.work import Work
from seoro.bridges.wire.refusal import RequestRefused
from seoro.concurrency.background import background
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

SPIN = "nav2_msgs/action/Spin"
EVENT = "lifecycle_msgs/msg/TransitionEvent"
INACTIVE, ACTIVE, FINALIZED = (
    {"id": number, "label": label} for number, label in ((2, "inactive"), (3, "active"), (4, "finalized"))
)


class Navigator:
    """A lifecycle node that serves an action."""

    def __init__(self) -> None:
        self.state: dict[str, Any] = INACTIVE
        self.goals = 0
        self.asked = anyio.Event()
        self.done = anyio.Event()

    async def get_state(self, _request: object) -> dict[str, Any]:
        self.asked.set()
        return {"current_state": self.state}

    async def spin(self, _goal: GoalHandle) -> GoalEnd:
        assert self.state is ACTIVE
        self.goals += 1
        self.done.set()
        return GoalEnd(Status.SUCCEEDED)


@asynccontextmanager
async def linked(router: str, types: TypeStore) -> AsyncIterator[tuple[RobotLink, Navigator, Any]]:
    """Yield a link to an inactive navigator, and the publisher of its transitions."""
    navigator = Navigator()
    async with (
        two_nodes(router, types) as (robot, here),
        # Nodes publish their state from the start, and serve actions once they are configured.
        robot.serving("~/get_state", "lifecycle_msgs/srv/GetState", navigator.get_state),
        serving_action(robot, "/spin", SPIN, navigator.spin),
        robot.publishing("~/transition_event", EVENT) as events,
        AsyncExitStack() as stack,
        anyio.create_task_group() as tasks,
    ):
        log = EventLog()
        link = RobotLink(here, stack, tasks, name="robot", work=Work(tasks, log), events=log)
        yield link, navigator, events
        tasks.cancel_scope.cancel()


class Stubborn(Navigator):
    """A navigator that refuses cancellations."""

    def __init__(self, code: int) -> None:
        super().__init__()
        self.code = code  # servers of rclcpp reject by 1, those of rclpy by 0 and no goal
        self.guard = GuardState()
        self.pending = False  # as the bridge knew while it had no answer

    async def send_goal(self, _request: object) -> dict[str, Any]:
        self.pending = self.guard.has_unanswered
        return {"accepted": True}

    async def cancel_goal(self, _request: object) -> dict[str, Any]:
        return {"return_code": self.code}

    async def get_result(self, _request: object) -> dict[str, Any]:
        await self.done.wait()
        return {"status": Status.SUCCEEDED}


@pytest.mark.parametrize(("code", "more"), [(1, " (return code 1)"), (0, "")])
async def test_goals_whose_cancel_fails_are_reported_and_active_until_they_end(
    code: int, more: str, router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    robot, events = Stubborn(code), EventLog()
    problem = f"the goal of /spin may continue: its server rejects to cancel it{more}"
    async with (
        two_nodes(router, types) as (there, here),
        there.serving("/spin/_action/send_goal", f"{SPIN}_SendGoal", robot.send_goal),
        there.serving("/spin/_action/get_result", f"{SPIN}_GetResult", robot.get_result),
        there.serving("/spin/_action/cancel_goal", CANCEL_GOAL, robot.cancel_goal),
        AsyncExitStack() as stack,
        background() as tasks,
    ):
        work = Work(tasks, events)
        with anyio.fail_after(30.0):
            link = RobotLink(here, stack, tasks, robot.guard, name="robot", work=work, events=events)
            await pursue(link, "one", ActionGoal("/spin", SPIN, {}))
            assert (robot.pending, robot.guard.has_unanswered) == (True, False)
            await work.cancel("one")
            reported = (await events.after(wire.AwaitEvents())).events
            assert [each.warning for each in reported] == [wire.GoalWarning(id="one", message=problem), None]
            assert problem in caplog.text
            assert work.busy(["robot"]) == ("robot",)
            robot.done.set()
            while work.busy(["robot"]):
                await anyio.sleep(0.01)


async def test_goals_wait_until_their_server_is_active(router: str, types: TypeStore) -> None:
    async with linked(router, types) as (link, navigator, events), anyio.create_task_group() as tasks:
        tasks.start_soon(pursue, link, "one", ActionGoal("/spin", SPIN, {}))
        await navigator.asked.wait()
        navigator.state = ACTIVE
        await events.wait_for_subscription(30.0)
        assert not navigator.goals
        events.publish({"start_state": INACTIVE, "goal_state": ACTIVE})
        with anyio.fail_after(30.0):
            await navigator.done.wait()


async def test_goals_are_refused_if_their_server_cannot_become_active(router: str, types: TypeStore) -> None:
    async with linked(router, types) as (link, navigator, _):
        navigator.state = FINALIZED
        with pytest.raises(RequestRefused, match="/robot, the server of /spin, is finalized, not active"):
            await pursue(link, "one", ActionGoal("/spin", SPIN, {}))
        assert navigator.goals == 0
