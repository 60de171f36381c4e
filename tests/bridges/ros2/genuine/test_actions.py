"""Actions between seoro and genuine nodes, in both roles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.clients.goals import sending_goal
from seoro.bridges.ros2.errors import GoalRejected
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.errors import BackendError
from seoro.runtime.contracts.backends import GoalStatus
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2
from tests.bridges.ros2.genuine.steering import own_node, steered

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

FIBONACCI = "test_msgs/action/Fibonacci"
PARTS = [[0], [0, 1], [0, 1, 1]]
FEEDBACK = [{"sequence": part} for part in PARTS]


def known(ros2: Ros2) -> TypeStore:
    """Return definitions with those of `test_msgs`, which seoro does not contain."""
    return TypeStore.bundled(folders=[Path(ros2.folder, "env", "share")])


@pytest.mark.parametrize(("order", "status"), [("succeed", GoalStatus.SUCCEEDED), ("abort", GoalStatus.ABORTED)])
async def test_goals_of_genuine_servers_end_with_feedback_and_result(
    ros2: Ros2, router: str, order: str, status: GoalStatus
) -> None:
    async with steered(ros2, router) as genuine, own_node(router, known(ros2)) as own:
        result = {"sequence": [0, 1, 1, 2]}
        await genuine.ask(
            "act", action="/fib", type=FIBONACCI, order=order, feedback=FEEDBACK, result=result, lasts=0.3
        )
        seen: list[Any] = []
        with anyio.fail_after(DEADLINE):
            async with sending_goal(own, "/fib", FIBONACCI, {"order": 3}, seen.append) as goal:
                end = await goal.ended()
        assert (end.status, list(end.result["sequence"])) == (status, [0, 1, 1, 2])
        assert [list(each["sequence"]) for each in seen] == PARTS
        assert (await genuine.event("goal"))["goal"] == {"order": 3}


async def test_rejected_goals_and_rejected_cancellations_are_reported(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router, known(ros2)) as own:
        await genuine.ask("act", action="/no", type=FIBONACCI, order="reject")
        with pytest.raises(GoalRejected):
            async with sending_goal(own, "/no", FIBONACCI, {"order": 3}, lambda _: None):
                pass
        await genuine.ask("act", action="/stubborn", type=FIBONACCI, cancels=False, lasts=600.0)
        with pytest.raises(BackendError, match="rejects to cancel it"):
            async with sending_goal(own, "/stubborn", FIBONACCI, {"order": 3}, lambda _: None):
                await genuine.event("goal")
        await genuine.event("cancel")


async def test_the_end_of_a_block_cancels_its_goal_only(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router, known(ros2)) as own:
        await genuine.ask("act", action="/fib", type=FIBONACCI, lasts=600.0)
        with anyio.fail_after(DEADLINE):
            async with sending_goal(own, "/fib", FIBONACCI, {"order": 1}, lambda _: None) as first:
                async with sending_goal(own, "/fib", FIBONACCI, {"order": 2}, lambda _: None) as second:
                    await genuine.event("goal", goal={"order": 1})
                    await genuine.event("goal", goal={"order": 2})
                await genuine.event("canceled")
                assert second.end is not None
                assert second.end.status is GoalStatus.CANCELED
                assert first.end is None
            await genuine.event("canceled")


async def test_goals_of_genuine_clients_are_executed(ros2: Ros2, router: str) -> None:
    async def execute(goal: GoalHandle) -> GoalEnd:
        numbers = [0, 1]
        for _ in range(min(goal.goal.order, 5)):  # clients keep 10 messages of feedback
            numbers.append(numbers[-1] + numbers[-2])
            goal.publish_feedback({"sequence": numbers})
        if goal.goal.order == 40:
            await anyio.sleep_forever()
        return GoalEnd(Status.ABORTED if goal.goal.order == 7 else Status.SUCCEEDED, {"sequence": numbers})

    async with (
        steered(ros2, router) as genuine,
        own_node(router, known(ros2)) as own,
        serving_action(own, "/fib", FIBONACCI, execute, lambda goal: goal.goal.order < 90),
    ):
        for order, status in ((3, Status.SUCCEEDED), (7, Status.ABORTED)):
            name = f"goal {order}"
            await genuine.ask("send_goal", action="/fib", type=FIBONACCI, goal={"order": order}, name=name)
            end = await genuine.event("result", goal=name)
            assert (end["status"], end["result"]["sequence"][:4]) == (status, [0, 1, 1, 2])
        await genuine.ask("send_goal", action="/fib", type=FIBONACCI, goal={"order": 99}, name="refused")
        assert (await genuine.event("accepted", goal="refused"))["accepted"] is False
        long = {"goal": {"order": 40}, "name": "long"}
        await genuine.ask("send_goal", action="/fib", type=FIBONACCI, **long)
        await genuine.event("feedback", goal="long", feedback={"sequence": [0, 1, 1]})
        await genuine.event("accepted", goal="long")
        with anyio.fail_after(DEADLINE):
            while not await genuine.ask("cancel_goal", name="long"):
                await anyio.sleep(0.05)
        assert (await genuine.event("result", goal="long"))["status"] == Status.CANCELED
