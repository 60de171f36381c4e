"""States of nodes that have a life cycle (managed nodes): the present one, and each that they come to.

A node tells of its transitions on `~/transition_event`, and of its state when asked by `~/get_state`. Transitions
lead through states such as `configuring`, in which nodes are while they work on it; those are no states to be in.
A node that dies tells nothing, but its services are gone.
"""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

from seoro.background import background
from seoro.bridges.ros2.clients.errors import NodeRefused
from seoro.bridges.ros2.clients.parameters import ANSWER_WITHIN
from seoro.bridges.ros2.errors import NoServiceServer
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Qos
from seoro.changes import Changes
from seoro.errors import SeoroError

EVENTS = Qos(depth=100)
GONE = "gone"  # the state of a node that is not there any more
STATES = {
    1: "unconfigured",
    2: "inactive",
    3: "active",
    4: "finalized",
}  # primary states, lifecycle_msgs/msg/State


class _States:
    """What is told of the states of a node, from what it says when asked and of its transitions.

    Args:
        tell: Told of each state.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._last = ""
        self._is_leaving = False  # on its way to another state

    def begin(self, state: str) -> None:
        """The node says that it is in a state, or in one on the way."""
        self._last, self._is_leaving = state, state not in STATES.values()
        if not self._is_leaving:
            self._tell(state)

    def take(self, event: Message) -> None:
        """The node tells of a transition; one from before it was asked does not begin in its state, and is old."""
        self._is_leaving = self._is_leaving or STATES.get(event.start_state.id) == self._last
        state = STATES.get(event.goal_state.id)
        if self._is_leaving and state is not None:
            self._is_leaving, self._last = False, state
            self._tell(state)

    def end(self) -> None:
        """The node is gone."""
        self._is_leaving = True
        self._tell(GONE)


@asynccontextmanager
async def following_lifecycle(node: RosNode, other: str) -> AsyncIterator[AsyncIterator[str]]:
    """Follow the states of another node for as long as the block lasts; `GONE` is one, too.

    Args:
        node: Who follows it.
        other: Full name of the other node.

    Raises:
        NodeRefused: There is no such node with a life cycle.
        CallFailed: It does not say in which state it is.
    """
    topic, type_name = f"{other}/transition_event", "lifecycle_msgs/msg/TransitionEvent"
    told = deque[str | SeoroError]()
    changes = Changes()

    def tell(what: str | SeoroError) -> None:
        told.append(what)
        changes.tell()

    async def states() -> AsyncIterator[str]:
        while True:
            await changes.wait_for(lambda: told)
            found = told.popleft()
            if isinstance(found, SeoroError):
                raise found
            yield found

    async with node.subscribing(topic, type_name, EVENTS) as events, background() as tasks:
        following = _States(tell)
        following.begin(await lifecycle_state(node, other))
        tasks.start_soon(_follow_transitions, events, following, tell)
        tasks.start_soon(_follow_presence, node, other, following)
        yield states()


async def _follow_transitions(
    events: Subscription, following: _States, tell: Callable[[str | SeoroError], None]
) -> None:
    try:
        async for received in events:
            following.take(events.decode(received))
    except SeoroError as error:  # it cannot be read
        tell(error)


async def _follow_presence(node: RosNode, other: str, following: _States) -> None:
    service = f"{other}/get_state"
    while True:
        await node.graph.wait_for(lambda seen: not seen.servers(service))
        following.end()
        await node.graph.wait_for(lambda seen: seen.servers(service))
        with suppress(SeoroError):  # then it may tell of its next transition
            following.begin(await lifecycle_state(node, other))


async def lifecycle_state(node: RosNode, other: str) -> str:
    """In which state another node is now; maybe one of those on the way.

    Raises:
        NodeRefused: There is no such node with a life cycle.
        CallFailed: It does not say.
    """
    async with node.calling(f"{other}/get_state", "lifecycle_msgs/srv/GetState") as client:
        try:
            await client.wait_for_server(ANSWER_WITHIN)
        except NoServiceServer:
            nodes = ", ".join(node.graph.nodes()) or "none"
            raise NodeRefused(f"there is no node {other} that has a life cycle; nodes are {nodes}") from None
        response = await client.call({}, ANSWER_WITHIN)
    state = response.current_state
    return STATES.get(state.id, str(state.label))
