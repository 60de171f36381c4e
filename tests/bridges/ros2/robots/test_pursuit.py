"""Goals of a robot's actions: whom they are sent to, and when."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import anyio
import pytest

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.ros2.action_server import GoalEnd, ServedGoal, Status, serving_action
from seoro.bridges.ros2.clients.recall import CANCEL_GOAL
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.pursuit import ActionGoal, pursue
from seoro.bridges.ros2.robots.unanswered import Unanswered
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.work import Work
from seoro.bridges.wire.refusal import RequestRefused
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

SPIN = "nav2_msgs/action/Spin"
EVENT = "lifecycle_msgs/msg/TransitionEvent"
INACTIVE, ACTIVE, FINALIZED = (
    {"id": number, "label": label} for number, label in ((2, "inactive"), (3, "active"), (4, "finalized"))
)


class Navigator:
    """A node with a life cycle that serves an action."""

    def __init__(self) -> None:
        self.state: dict[str, Any] = INACTIVE
        self.goals = 0
        self.asked = anyio.Event()
        self.done = anyio.Event()

    async def get_state(self, _request: object) -> dict[str, Any]:
        self.asked.set()
        return {"current_state": self.state}

    async def spin(self, _goal: ServedGoal) -> GoalEnd:
        assert self.state is ACTIVE
        self.goals += 1
        self.done.set()
        return GoalEnd(Status.SUCCEEDED)


@asynccontextmanager
async def linked(router: str, types: TypeStore) -> AsyncIterator[tuple[Link, Work, Navigator, Any]]:
    """A link to a navigator that is not active yet, and what tells of its transitions."""
    navigator = Navigator()
    async with (
        two_nodes(router, types) as (robot, here),
        # Nodes tell their state from the beginning, and serve actions once they are configured.
        robot.serving("~/get_state", "lifecycle_msgs/srv/GetState", navigator.get_state),
        serving_action(robot, "/spin", SPIN, navigator.spin),
        robot.publishing("~/transition_event", EVENT) as events,
        AsyncExitStack() as stack,
        anyio.create_task_group() as tasks,
    ):
        yield Link(here, stack, tasks), Work(tasks, HappeningLog()), navigator, events
        tasks.cancel_scope.cancel()


class Stubborn(Navigator):
    """A navigator that takes goals, and none back."""

    def __init__(self, code: int) -> None:
        super().__init__()
        self.code = code  # servers of rclcpp reject by 1, those of rclpy by 0 and no goal
        self.unanswered = Unanswered()
        self.pending = False  # as the bridge knew while it had no answer

    async def send_goal(self, _request: object) -> dict[str, Any]:
        self.pending = self.unanswered.is_any
        return {"accepted": True}

    async def cancel_goal(self, _request: object) -> dict[str, Any]:
        return {"return_code": self.code}

    async def get_result(self, _request: object) -> dict[str, Any]:
        await self.done.wait()
        return {"status": Status.SUCCEEDED}


@pytest.mark.parametrize(("code", "more"), [(1, " (return code 1)"), (0, "")])
async def test_goals_that_cannot_be_canceled_are_told_and_count_until_they_end(
    code: int, more: str, router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    robot, happenings = Stubborn(code), HappeningLog()
    problem = f"the goal of /spin may go on: its server rejects to cancel it{more}"
    async with (
        two_nodes(router, types) as (there, here),
        there.serving("/spin/_action/send_goal", f"{SPIN}_SendGoal", robot.send_goal),
        there.serving("/spin/_action/get_result", f"{SPIN}_GetResult", robot.get_result),
        there.serving("/spin/_action/cancel_goal", CANCEL_GOAL, robot.cancel_goal),
        AsyncExitStack() as stack,
        background() as tasks,
    ):
        work = Work(tasks, happenings)
        with anyio.fail_after(30.0):
            link = Link(here, stack, tasks, unanswered=robot.unanswered)
            await pursue(link, work, "one", "robot", ActionGoal("/spin", SPIN, {}))
            assert (robot.pending, robot.unanswered.is_any) == (True, False)
            await work.cancel("one")
            told = (await happenings.after(wire.AwaitHappenings())).happenings
            assert [each.caution for each in told] == [wire.Caution(id="one", message=problem), None]
            assert problem in caplog.text
            assert work.busy(["robot"]) == ("robot",)
            robot.done.set()
            while work.busy(["robot"]):
                await anyio.sleep(0.01)


async def test_goals_wait_until_who_serves_them_is_active(router: str, types: TypeStore) -> None:
    async with linked(router, types) as (link, work, navigator, events), anyio.create_task_group() as tasks:
        tasks.start_soon(pursue, link, work, "one", "robot", ActionGoal("/spin", SPIN, {}))
        await navigator.asked.wait()
        navigator.state = ACTIVE
        await events.wait_for_subscription(5.0)
        assert not navigator.goals
        events.publish({"start_state": INACTIVE, "goal_state": ACTIVE})
        with anyio.fail_after(30.0):
            await navigator.done.wait()


async def test_goals_are_refused_if_who_serves_them_will_not_be_active(router: str, types: TypeStore) -> None:
    async with linked(router, types) as (link, work, navigator, _):
        navigator.state = FINALIZED
        with pytest.raises(RequestRefused, match="/robot, which serves /spin, is finalized, not active"):
            await pursue(link, work, "one", "robot", ActionGoal("/spin", SPIN, {}))
        assert navigator.goals == 0
