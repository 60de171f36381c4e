"""Cancellation of orphaned goals at a robot: goals whose process of seoro has ended.

Action servers publish their goals on `NAME/_action/status`. IDs of goals of seoro identify the session that sent
them (`goal_ids.py`), and the graph lists the live sessions. Goals of other clients are left alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import TaskStatus

from seoro.bridges.ros2.clients.cancellation import cancel_goal
from seoro.bridges.ros2.clients.goal_ids import decode_sender, session_digest
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.wire import LATCHED
from seoro.bridges.session import Bound

STATUSES: Final = "action_msgs/msg/GoalStatusArray"
ACTIVE: Final = (1, 2)  # accepted, executing: action_msgs/msg/GoalStatus
WAITING: Final = Bound(100)  # so that messages of other publishers do not displace a status
GONE_FOR: Final = 1.0  # [s]; after the restart of a router, tokens come back one after the other

Note = Callable[[str], None]


class GoalSenders:
    """Live sessions of seoro, and the active goals that they have sent.

    Args:
        graph: Graph of the system.
    """

    def __init__(self, graph: RosGraph) -> None:
        self._graph = graph
        self._disowned: set[tuple[bytes, str]] = set()  # digests of sessions, and actions
        self._active: dict[str, frozenset[bytes]] = {}

    def disown(self, session: str, actions: Iterable[str]) -> None:
        """Treat the goals of a session at some actions as orphaned, until they are reclaimed."""
        self._disowned.update((session_digest(session), action) for action in actions)
        self._graph.change(())

    def reclaim(self, session: str, actions: Iterable[str]) -> None:
        """End the effect of `disown`."""
        self._disowned.difference_update((session_digest(session), action) for action in actions)

    def set_active(self, action: str, senders: Iterable[bytes]) -> None:
        """Set the session digests of the active goals of an action."""
        self._active[action] = frozenset(senders)
        self._graph.change(())

    async def wait_without_goals(self, session: str) -> None:
        """Wait until a session has no active goal."""
        sender = session_digest(session)
        await self._graph.wait_for(lambda _: all(sender not in senders for senders in self._active.values()))

    async def wait_gone(self, sender: bytes, action: str) -> None:
        """Wait until the session of a digest has disappeared while an action has a server, or is disowned.

        Without the server, the connection of this process may be lost.
        """

        def is_disowned() -> bool:
            return (sender, action) in self._disowned

        def is_missing() -> bool:
            seen = self._graph.sessions()
            is_served = bool(self._graph.action_servers(action))
            return is_served and all(session_digest(each) != sender for each in seen)

        while True:
            await self._graph.wait_for(lambda _: is_disowned() or is_missing())
            try:
                await self._graph.wait_for(lambda _: is_disowned() or not is_missing(), GONE_FOR)
            except TimeoutError:
                return
            if is_disowned():
                return


async def cancel_orphaned_goals(
    node: RosNode,
    action: str,
    senders: GoalSenders,
    note: Note,
    *,
    task_status: TaskStatus[None] = TASK_STATUS_IGNORED,
) -> None:
    """Cancel orphaned goals of an action, until the task is cancelled.

    Args:
        node: Requesting node.
        action: Name of the action.
        senders: Live sessions.
        note: Called with canceled goals, and, once per kind, with undecodable messages.
        task_status: Called when the subscription is open.
    """
    action = node.resolve(action)
    watched: dict[bytes, anyio.CancelScope] = {}

    async def cancel_if_orphaned(goal_id: bytes, sender: bytes, scope: anyio.CancelScope) -> None:
        with scope:
            await senders.wait_gone(sender, action)
            await cancel_goal(node, action, goal_id, note)

    subscribing = node.subscribing(f"{action}/_action/status", STATUSES, LATCHED, WAITING, is_checked=False)
    async with subscribing as statuses, anyio.create_task_group() as tasks:
        task_status.started()
        async for _, message in statuses.decoded(note):
            active = _active_goals(message)
            senders.set_active(action, active.values())
            for goal_id in watched.keys() - active.keys():
                watched.pop(goal_id).cancel()
            for goal_id in active.keys() - watched.keys():
                scope = watched[goal_id] = anyio.CancelScope()
                tasks.start_soon(cancel_if_orphaned, goal_id, active[goal_id], scope)


def _active_goals(message: Message) -> dict[bytes, bytes]:
    """Return the active goals of seoro, with the digests of their sessions."""
    goal_ids = [bytes(each.goal_info.goal_id.uuid) for each in message.status_list if each.status in ACTIVE]
    return {goal_id: sender for goal_id in goal_ids if (sender := decode_sender(goal_id)) is not None}
