"""States of nodes that have a life cycle (managed nodes): the present one, and each that they come to.

A node tells of its transitions on `~/transition_event`, and of its state when asked by `~/get_state`. Transitions
lead through states such as `configuring`, in which nodes are while they work on it; those are no states to be in.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from seoro.bridges.ros2.clients.errors import NodeRefused
from seoro.bridges.ros2.clients.parameters import ANSWER_WITHIN
from seoro.bridges.ros2.errors import NoServiceServer
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.wire import Qos

EVENTS = Qos(depth=100)
STATES = {
    1: "unconfigured",
    2: "inactive",
    3: "active",
    4: "finalized",
}  # primary states, lifecycle_msgs/msg/State


@asynccontextmanager
async def following_lifecycle(node: RosNode, other: str) -> AsyncIterator[AsyncIterator[str]]:
    """Follow the states of another node for as long as the block lasts.

    Args:
        node: Who follows it.
        other: Full name of the other node.

    Raises:
        NodeRefused: There is no such node with a life cycle.
        CallFailed: It does not say in which state it is.
    """
    topic, type_name = f"{other}/transition_event", "lifecycle_msgs/msg/TransitionEvent"
    async with node.subscribing(topic, type_name, EVENTS) as events:
        first = await lifecycle_state(node, other)

        async def states() -> AsyncIterator[str]:
            last = first
            is_leaving = last not in STATES.values()
            if not is_leaving:
                yield last
            async for received in events:
                event = events.decode(received)
                # What happened before it said in which state it is does not begin there, and is old.
                is_leaving = is_leaving or STATES.get(event.start_state.id) == last
                state = STATES.get(event.goal_state.id)
                if is_leaving and state is not None:
                    is_leaving, last = False, state
                    yield state

        yield states()


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
