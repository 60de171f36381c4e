"""Goals that are cancelled before their server has accepted them."""

from __future__ import annotations

from contextlib import AsyncExitStack
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.clients.cancellation import CANCEL_GOAL, UNKNOWN, cancel_goal
from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.errors import NoResponse
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.concurrency.background import background
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

SPIN = "nav2_msgs/action/Spin"
DEADLINE = 30.0  # [s]


class SlowServer:
    """An action server that accepts goals on request, and does not know them before."""

    def __init__(self) -> None:
        self.asked, self.lets, self.refused, self.canceled = (anyio.Event() for _ in range(4))

    async def send_goal(self, _request: object) -> dict[str, Any]:
        self.asked.set()
        await self.lets.wait()
        return {"accepted": True}

    async def cancel_goal(self, request: Any) -> dict[str, Any]:
        if not self.lets.is_set():
            self.refused.set()
            return {"return_code": UNKNOWN}
        self.canceled.set()
        return {"goals_canceling": [request.goal_info]}

    async def get_result(self, _request: object) -> dict[str, Any]:
        await self.canceled.wait()
        return {"status": 5 if self.lets.is_set() else 0}


@pytest.mark.parametrize("how", ["is cancelled", "has no answer"])
async def test_a_goal_accepted_after_its_cancellation_is_canceled(
    how: str, router: str, types: TypeStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    goals = "seoro.bridges.ros2.clients.goals"
    monkeypatch.setattr(f"{goals}.CANCEL_TIMEOUT", 1.0)
    monkeypatch.setattr(f"{goals}.ANSWER_TIMEOUT", 0.2 if how == "has no answer" else DEADLINE)
    server, notes = SlowServer(), list[str]()
    async with (
        two_nodes(router, types) as (there, here),
        background() as tasks,
        AsyncExitStack() as served,
    ):
        for part in ("send_goal", "get_result"):
            type_name = f"{SPIN}_{'SendGoal' if part == 'send_goal' else 'GetResult'}"
            await served.enter_async_context(
                there.serving(f"/spin/_action/{part}", type_name, getattr(server, part))
            )
        await served.enter_async_context(
            there.serving("/spin/_action/cancel_goal", CANCEL_GOAL, server.cancel_goal)
        )

        def call_off(doubt: Goal) -> None:
            assert doubt.is_lost
            tasks.start_soon(cancel_goal, here, doubt.action, doubt.goal_id, notes.append)

        async def pursue() -> None:
            async with sending_goal(here, "/spin", SPIN, {}, lambda _: None, notes.append, call_off):
                raise AssertionError("it is not taken")

        with anyio.fail_after(DEADLINE):
            if how == "has no answer":
                with pytest.raises(NoResponse):
                    await pursue()
            else:
                async with anyio.create_task_group() as sender:
                    sender.start_soon(pursue)
                    await server.asked.wait()
                    sender.cancel_scope.cancel()
                assert notes[0].startswith("the goal of /spin may continue: ")
            await server.refused.wait()
            server.lets.set()
            await server.canceled.wait()
            while "/spin: the server cancels a goal without a client" not in notes:
                await anyio.sleep(0.01)
