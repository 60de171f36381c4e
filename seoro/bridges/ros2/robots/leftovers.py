"""Goals that processes of seoro have left behind at a robot: whoever pursued them is gone, so they are canceled.

Servers of actions tell which goals they have on `NAME/_action/status`. Numbers of seoro's goals say by which
session they were sent (`numbers.py`), and the graph which sessions there are. Goals of others are left alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final

import anyio
from anyio import TASK_STATUS_IGNORED
from anyio.abc import TaskStatus

from seoro.bridges.ros2.clients.numbers import digest, sender_of
from seoro.bridges.ros2.clients.recall import recall
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.bridges.session import Bound
from seoro.errors import BackendError, InvalidUse

STATUSES: Final = "action_msgs/msg/GoalStatusArray"
LATCHED: Final = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
GOING: Final = (1, 2)  # accepted, executing: action_msgs/msg/GoalStatus
WAITING: Final = Bound(100)  # servers tell statuses when they change: what others publish displaces none
GONE_FOR: Final = 1.0  # [s]; when a router has been started again, tokens come back one after the other

Note = Callable[[str], None]


class Senders:
    """Which sessions of seoro's there are, and which goals they have sent that go on.

    Args:
        graph: Of the system.
    """

    def __init__(self, graph: RosGraph) -> None:
        self._graph = graph
        self._given_up: set[tuple[bytes, str]] = set()  # sessions, and actions at which they count as gone
        self._going: dict[str, frozenset[bytes]] = {}

    def give_up(self, session: str, actions: Iterable[str]) -> None:
        """Cancel the goals of a session at some actions, as if it were gone, until it is taken back."""
        self._given_up.update((digest(session), action) for action in actions)
        self._graph.change(())

    def take_back(self, session: str, actions: Iterable[str]) -> None:
        """Cancel no more goals of a session at some actions."""
        self._given_up.difference_update((digest(session), action) for action in actions)

    def note_going(self, action: str, senders: Iterable[bytes]) -> None:
        """The digests of those whose goals an action has."""
        self._going[action] = frozenset(senders)
        self._graph.change(())

    async def wait_without_goals(self, session: str) -> None:
        """Wait until no goal of a session goes on."""
        sender = digest(session)
        await self._graph.wait_for(lambda _: all(sender not in going for going in self._going.values()))

    async def wait_gone(self, sender: bytes, action: str) -> None:
        """Wait until the session of a digest is gone while an action is served.

        Where nobody is seen at all, it is the connection of this process that is gone.
        """

        def is_given_up() -> bool:
            return (sender, action) in self._given_up

        def is_missing() -> bool:
            seen = self._graph.sessions()
            return bool(self._graph.action_servers(action)) and all(digest(each) != sender for each in seen)

        while True:
            await self._graph.wait_for(lambda _: is_given_up() or is_missing())
            try:
                await self._graph.wait_for(lambda _: is_given_up() or not is_missing(), GONE_FOR)
            except TimeoutError:
                return
            if is_given_up():
                return


async def end_leftovers(
    node: RosNode,
    action: str,
    senders: Senders,
    note: Note,
    *,
    task_status: TaskStatus[None] = TASK_STATUS_IGNORED,
) -> None:
    """Cancel goals of an action whose senders are gone; runs until it is cancelled.

    Args:
        node: Who asks.
        action: Name of the action.
        senders: Who is there.
        note: Told what is canceled, and, once for each kind, what is not understood.
        task_status: Told when no goal is missed any more.
    """
    topic = f"{node.resolve(action)}/_action/status"
    async with node.subscribing(topic, STATUSES, LATCHED, WAITING, is_checked=False) as told:
        task_status.started()
        await _follow(node, node.resolve(action), told, senders, note)


async def _follow(node: RosNode, action: str, told: Subscription, senders: Senders, note: Note) -> None:
    watched: dict[bytes, anyio.CancelScope] = {}
    noted: set[type[Exception]] = set()

    async def end(number: bytes, sender: bytes, scope: anyio.CancelScope) -> None:
        with scope:
            await senders.wait_gone(sender, action)
            await recall(node, action, number, note)

    async with anyio.create_task_group() as tasks:
        async for received in told:
            try:
                going = _going(told.decode(received))
            except (BackendError, InvalidUse) as error:  # which says nothing of the goals that there are
                if type(error) not in noted:
                    note(str(error))
                noted.add(type(error))
                continue
            senders.note_going(action, going.values())
            for number in watched.keys() - going.keys():
                watched.pop(number).cancel()
            for number in going.keys() - watched.keys():
                scope = watched[number] = anyio.CancelScope()
                tasks.start_soon(end, number, going[number], scope)


def _going(told: Message) -> dict[bytes, bytes]:
    """The goals of seoro's that go on, with the digests of the sessions that have sent them."""
    numbers = [bytes(each.goal_info.goal_id.uuid) for each in told.status_list if each.status in GOING]
    return {number: sender for number in numbers if (sender := sender_of(number)) is not None}
