"""Calling off goals that nobody pursues any more.

A server that does not know a goal may still have the request in which it was sent, and take it later. It is asked
again for a while.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import anyio

from seoro.bridges.ros2.participant import RosNode
from seoro.errors import SeoroError

CANCEL_GOAL: Final = "action_msgs/srv/CancelGoal"
ANSWER_WITHIN: Final = 2.0  # [s] until a server has said whether it cancels a goal
RECALLED_WITHIN: Final = 3600.0  # [s]
TAKEN_WITHIN: Final = 60.0  # [s] from when a server says that it does not know a goal: it may yet take it
RETRY: Final = 0.2  # [s] between two attempts
UNKNOWN, ENDED = 2, 3  # why there is nothing to cancel: the server does not know the goal, or it has ended


def is_rejected(response: Any, number: bytes) -> bool:
    """Whether a server rejects the request to cancel a goal.

    Servers of rclcpp reject by a return code. Those of rclpy reject by success and a list without the goal.

    Args:
        response: Of `action_msgs/srv/CancelGoal`.
        number: The goal.
    """
    if response.return_code:
        return response.return_code not in (UNKNOWN, ENDED)
    return all(bytes(each.goal_id.uuid) != number for each in response.goals_canceling)


async def recall(node: RosNode, action: str, number: bytes, note: Callable[[str], None]) -> None:
    """Cancel a goal of which its sender has lost sight, as soon as its server can be asked.

    Args:
        node: Who asks.
        action: Full name of the action.
        number: The goal.
        note: Called with a text when the server begins to cancel it, or rejects that.
    """
    service = f"{action}/_action/cancel_goal"
    request = {"goal_info": {"goal_id": {"uuid": list(number)}}}
    with anyio.move_on_after(RECALLED_WITHIN) as attempts:
        while True:
            await node.graph.wait_for(lambda graph: graph.servers(service) or None)
            try:
                async with node.calling(service, CANCEL_GOAL) as client:
                    while (response := await client.call(request, ANSWER_WITHIN)).return_code == UNKNOWN:
                        attempts.deadline = min(attempts.deadline, anyio.current_time() + TAKEN_WITHIN)
                        await anyio.sleep(RETRY)
            except SeoroError:
                await anyio.sleep(RETRY)
                continue
            if is_rejected(response, number):
                note(f"{action}: a goal that nobody pursues any more goes on: its server rejects to cancel it")
            elif response.return_code != ENDED:
                note(f"{action}: the server cancels a goal that nobody pursued any more")
            return


async def wait_ended(node: RosNode, action: str, type_name: str, number: bytes) -> None:
    """Wait until the server of a goal says how it has ended, or that it does not know it.

    Args:
        node: Who asks.
        action: Full name of the action.
        type_name: Its type.
        number: The goal.
    """
    service = f"{action}/_action/get_result"
    while True:
        await node.graph.wait_for(lambda graph: graph.servers(service) or None)
        try:
            async with node.calling(service, f"{type_name}_GetResult") as client:
                await client.call({"goal_id": {"uuid": list(number)}})
                return
        except SeoroError:
            await anyio.sleep(RETRY)
