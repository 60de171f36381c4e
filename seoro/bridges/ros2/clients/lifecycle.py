"""States of lifecycle nodes (managed nodes): the present one, and each later one.

A node publishes its transitions on `~/transition_event`, and returns its state from `~/get_state`. Transition
states such as `configuring` are not reported as states. A node that dies publishes nothing, but its services
disappear.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

from seoro.bridges.ros2.clients.parameters import call_node
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Qos
from seoro.concurrency.background import background
from seoro.errors import SeoroError

EVENTS = Qos(depth=100)
GONE = "gone"  # state of a node that has disappeared
STATES = {1: "unconfigured", 2: "inactive", 3: "active", 4: "finalized"}  # primary: lifecycle_msgs/msg/State


class StateTracker:
    """State of a node, from its response and its transitions.

    Args:
        report: Called with each state.

    Attributes:
        is_changing: Whether a transition has begun and not ended.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        self._report = report
        self._last = ""
        self.is_changing = False

    def set(self, state: str) -> None:
        """Set the state that the node has responded, possibly a transition state."""
        self._last, self.is_changing = state, state not in STATES.values()
        if not self.is_changing:
            self._report(state)

    def apply(self, event: Message) -> None:
        """Apply a transition; ignore one that happened before the response, which starts in another state."""
        self.is_changing = self.is_changing or STATES.get(event.start_state.id) == self._last
        state = STATES.get(event.goal_state.id)
        if self.is_changing and state is not None:
            self.is_changing, self._last = False, state
            self._report(state)

    def set_gone(self) -> None:
        """Report that the node has disappeared."""
        self.is_changing = True
        self._report(GONE)


@asynccontextmanager
async def watching_lifecycle(node: RosNode, other: str) -> AsyncIterator[AsyncIterator[str]]:
    """Follow the states of another node during the block, including `GONE`.

    Args:
        node: Subscribing node.
        other: Full name of the other node.

    Raises:
        NodeRefused: The node is unknown, or has no life cycle.
        CallFailed: The node does not send its state.
    """
    topic, type_name = f"{other}/transition_event", "lifecycle_msgs/msg/TransitionEvent"
    reports = asyncio.Queue[str | SeoroError]()

    async def states() -> AsyncIterator[str]:
        while True:
            state = await reports.get()
            if isinstance(state, SeoroError):
                raise state
            yield state

    async with node.subscribing(topic, type_name, EVENTS) as events, background() as tasks:
        tracker = StateTracker(reports.put_nowait)
        tracker.set(await lifecycle_state(node, other))
        tasks.start_soon(_follow_transitions, events, tracker, reports)
        tasks.start_soon(_follow_presence, node, other, tracker)
        yield states()


async def _follow_transitions(
    events: Subscription, tracker: StateTracker, reports: asyncio.Queue[str | SeoroError]
) -> None:
    try:
        async for received in events:
            tracker.apply(events.decode(received))
    except SeoroError as error:  # the message is undecodable
        reports.put_nowait(error)


async def _follow_presence(node: RosNode, other: str, tracker: StateTracker) -> None:
    service = f"{other}/get_state"
    while True:
        await node.graph.wait_for(lambda graph: not graph.servers(service))
        tracker.set_gone()
        await node.graph.wait_for(lambda graph: graph.servers(service))
        with suppress(SeoroError):  # its next transition may be published nonetheless
            tracker.set(await lifecycle_state(node, other))


def state_name(state: Message) -> str:
    """Return the name of a `lifecycle_msgs/msg/State`."""
    return STATES.get(state.id, str(state.label))


async def lifecycle_state(node: RosNode, other: str) -> str:
    """Return the present state of another node, possibly a transition state.

    Raises:
        NodeRefused: The node is unknown, or has no life cycle.
        CallFailed: The node does not send its state.
    """
    response = await call_node(node, other, "get_state", "lifecycle_msgs/srv/GetState", {}, "a life cycle")
    return state_name(response.current_state)
