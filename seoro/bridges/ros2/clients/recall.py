"""Calling off goals that nobody pursues any more."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import anyio

from seoro.bridges.ros2.participant import RosNode
from seoro.errors import SeoroError

CANCEL_GOAL: Final = "action_msgs/srv/CancelGoal"
ANSWER_WITHIN: Final = 2.0  # [s] until a server has said whether it cancels a goal
RECALLED_WITHIN: Final = 3600.0  # [s]
RETRY: Final = 0.2  # [s] between two attempts
GONE: Final = (2, 3)  # why there is nothing to cancel: the server does not know the goal, or it has ended


async def recall(node: RosNode, action: str, number: bytes, note: Callable[[str], None]) -> None:
    """Cancel a goal of which its sender has lost sight, as soon as its server can be asked.

    Args:
        node: Who asks.
        action: Full name of the action.
        number: The goal.
        note: Told when it is canceled, or cannot be.
    """
    service = f"{action}/_action/cancel_goal"
    with anyio.move_on_after(RECALLED_WITHIN):
        while True:
            await node.graph.wait_for(lambda graph: graph.servers(service) or None)
            try:
                async with node.calling(service, CANCEL_GOAL) as client:
                    info = {"goal_id": {"uuid": list(number)}}
                    code = (await client.call({"goal_info": info}, ANSWER_WITHIN)).return_code
            except SeoroError:
                await anyio.sleep(RETRY)
                continue
            if not code:
                note(f"{action}: a goal that nobody pursued any more was canceled")
            elif code not in GONE:
                note(f"{action}: a goal that nobody pursues any more goes on: its server rejects to cancel it")
            return
