from __future__ import annotations

import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.action_server import KEPT_GOALS, GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.services import Client
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.errors import ActionFailed
from tests.bridges.ros2.systems import two_nodes

FIBONACCI = "example_interfaces/action/Fibonacci"


async def carry_out(goal: GoalHandle) -> GoalEnd:
    """Compute Fibonacci numbers; order 40 never ends, and 99 fails."""
    if goal.goal.order == 99:
        raise ActionFailed("99 goes wrong")
    numbers = [0, 1]
    for _ in range(goal.goal.order):
        numbers.append(numbers[-1] + numbers[-2])
        goal.publish_feedback({"sequence": numbers})
    if goal.goal.order == 40:
        await anyio.sleep_forever()
    return GoalEnd(Status.SUCCEEDED, {"sequence": numbers})


@dataclass
class Peer:
    """A client of the action server."""

    send: Client
    result: Client
    cancel: Client
    feedback: Subscription
    status: Subscription

    async def goal(self, order: int, number: bytes | None = None) -> tuple[bytes, bool]:
        number = number or secrets.token_bytes(16)
        request = {"goal_id": {"uuid": list(number)}, "goal": {"order": order}}
        return number, bool((await self.send.call(request, 5.0)).accepted)

    async def end(self, number: bytes) -> Any:
        return await self.result.call({"goal_id": {"uuid": list(number)}}, 5.0)

    async def call_off(self, number: bytes = bytes(16), sec: int = 0) -> Any:
        info = {"goal_id": {"uuid": list(number)}, "stamp": {"sec": sec}}
        return await self.cancel.call({"goal_info": info}, 5.0)


@asynccontextmanager
async def serving(router: str, types: TypeStore) -> AsyncIterator[Peer]:
    def accept(goal: GoalHandle) -> bool:
        return bool(goal.goal.order >= 0)

    below, latched = "/fibonacci/_action", Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
    async with (
        two_nodes(router, types) as (robot, here),
        serving_action(robot, "fibonacci", FIBONACCI, carry_out, accept),
        here.calling(f"{below}/send_goal", f"{FIBONACCI}_SendGoal") as send,
        here.calling(f"{below}/get_result", f"{FIBONACCI}_GetResult") as result,
        here.calling(f"{below}/cancel_goal", "action_msgs/srv/CancelGoal") as cancel,
        here.subscribing(f"{below}/feedback", f"{FIBONACCI}_FeedbackMessage", Qos(depth=100)) as feedback,
        here.subscribing(f"{below}/status", "action_msgs/msg/GoalStatusArray", latched) as status,
    ):
        for client in (send, result, cancel):
            await client.wait_for_server(30.0)
        assert here.graph.actions() == {"/fibonacci": (FIBONACCI,)}
        yield Peer(send, result, cancel, feedback, status)


async def test_goals_are_executed_with_feedback(router: str, types: TypeStore) -> None:
    async with serving(router, types) as peer:
        number, accepted = await peer.goal(5)
        assert accepted
        end = await peer.end(number)
        assert (end.status, end.result.sequence.tolist()) == (Status.SUCCEEDED, [0, 1, 1, 2, 3, 5, 8])
        reported = [await peer.feedback.message() for _ in range(5)]
        assert bytes(reported[0].goal_id.uuid) == number
        assert reported[-1].feedback.sequence.tolist() == [0, 1, 1, 2, 3, 5, 8]
        with anyio.fail_after(30.0):
            while (await peer.status.message()).status_list[0].status != Status.SUCCEEDED:
                pass
        assert await peer.goal(5, number) == (number, False)
        assert not (await peer.goal(-1))[1]
        failed, _ = await peer.goal(99)
        assert (await peer.end(failed)).status == Status.ABORTED
        assert (await peer.end(bytes(16))).status == Status.UNKNOWN


async def test_goals_are_canceled(router: str, types: TypeStore) -> None:
    async with serving(router, types) as peer:
        one, other, third = [(await peer.goal(40))[0] for _ in range(3)]
        answer = await peer.call_off(one)
        assert [bytes(info.goal_id.uuid) for info in answer.goals_canceling] == [one]
        assert (await peer.end(one)).status == Status.CANCELED
        assert (await peer.call_off(one)).return_code == 3
        assert (await peer.call_off(b"x" * 16)).return_code == 2
        assert len((await peer.call_off(sec=1)).goals_canceling) == 0
        assert len((await peer.call_off()).goals_canceling) == 2
        assert {(await peer.end(number)).status for number in (other, third)} == {Status.CANCELED}


@pytest.mark.more
async def test_old_results_are_dropped(router: str, types: TypeStore) -> None:
    async with serving(router, types) as peer:
        first, _ = await peer.goal(0)
        for _ in range(KEPT_GOALS):
            await peer.goal(0)
        assert (await peer.end(first)).status == Status.UNKNOWN
