"""Cancellation of goals that have lost their client.

A server that does not know a goal may still have its request queued, and accept it later. So the request to cancel
is repeated for a while.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import anyio

from seoro.bridges.ros2.participant import RosNode
from seoro.errors import SeoroError

CANCEL_GOAL: Final = "action_msgs/srv/CancelGoal"
ANSWER_TIMEOUT: Final = 2.0  # [s]
CANCEL_TIMEOUT: Final = 3600.0  # [s]
ACCEPT_TIMEOUT: Final = 60.0  # [s] in which a server may accept a goal that it did not know
RETRY: Final = 0.2  # [s] between two attempts
UNKNOWN, ENDED = 2, 3  # return codes: unknown goal, ended goal (action_msgs/srv/CancelGoal)


def is_rejected(response: Any, goal_id: bytes) -> bool:
    """Return whether a server rejects the request to cancel a goal.

    Servers of rclcpp reject with a return code. Servers of rclpy report success and a list without the goal.

    Args:
        response: Response of `action_msgs/srv/CancelGoal`.
        goal_id: ID of the goal.
    """
    if response.return_code:
        return response.return_code not in (UNKNOWN, ENDED)
    return all(bytes(each.goal_id.uuid) != goal_id for each in response.goals_canceling)


async def cancel_goal(node: RosNode, action: str, goal_id: bytes, note: Callable[[str], None]) -> None:
    """Cancel a goal that has lost its client, as soon as its server is reachable.

    Args:
        node: Requesting node.
        action: Full name of the action.
        goal_id: ID of the goal.
        note: Called with a text when the server cancels the goal, or rejects to.
    """
    service = f"{action}/_action/cancel_goal"
    request = {"goal_info": {"goal_id": {"uuid": goal_id}}}
    with anyio.move_on_after(CANCEL_TIMEOUT) as attempts:
        while True:
            await node.graph.wait_for(lambda graph: graph.servers(service) or None)
            try:
                async with node.calling(service, CANCEL_GOAL) as client:
                    while (response := await client.call(request, ANSWER_TIMEOUT)).return_code == UNKNOWN:
                        attempts.deadline = min(attempts.deadline, anyio.current_time() + ACCEPT_TIMEOUT)
                        await anyio.sleep(RETRY)
            except SeoroError:
                await anyio.sleep(RETRY)
                continue
            if is_rejected(response, goal_id):
                note(f"{action}: a goal without a client continues: its server rejects to cancel it")
            elif response.return_code != ENDED:
                note(f"{action}: the server cancels a goal without a client")
            return


async def wait_ended(node: RosNode, action: str, type_name: str, goal_id: bytes) -> None:
    """Wait until the server of a goal returns its result, or does not know the goal.

    Args:
        node: Requesting node.
        action: Full name of the action.
        type_name: Type of the action.
        goal_id: ID of the goal.
    """
    service = f"{action}/_action/get_result"
    while True:
        await node.graph.wait_for(lambda graph: graph.servers(service) or None)
        try:
            async with node.calling(service, f"{type_name}_GetResult") as client:
                await client.call({"goal_id": {"uuid": goal_id}})
                return
        except SeoroError:
            await anyio.sleep(RETRY)
