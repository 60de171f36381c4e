"""Actions of `osc.ros` that wait for something to be there: nodes, topics, services, and who has them.

They end as soon as what they wait for is announced; nothing is asked for again and again. When one is ended
before, such as by `timeout`, it says what was not there.
"""

from __future__ import annotations

from collections.abc import Sequence

from seoro.actions.reports import meanwhile
from seoro.actions.ros_support import failing, system_of, telling
from seoro.errors import ActionFailed
from seoro.runtime.actions import action
from seoro.runtime.context import ActionContext
from seoro.runtime.ros_system import Ros2System, Wanted


@action("wait_for_nodes", anywhere=Ros2System)
async def wait_for_nodes(ctx: ActionContext, nodes: Sequence[str]) -> None:
    """Wait until all of some nodes are there."""
    await _wait(ctx, [Wanted("node", name) for name in nodes])


@action("wait_for_topics", anywhere=Ros2System)
async def wait_for_topics(ctx: ActionContext, topics: Sequence[str]) -> None:
    """Wait until somebody publishes or subscribes to all of some topics."""
    await _wait(ctx, [Wanted("topic", name) for name in topics])


@action("wait_for_services", anywhere=Ros2System)
async def wait_for_services(ctx: ActionContext, services: Sequence[str]) -> None:
    """Wait until all of some services are served."""
    await _wait(ctx, [Wanted("service", name) for name in services])


@action("wait_for_topic_publisher", anywhere=Ros2System)
async def wait_for_topic_publisher(ctx: ActionContext, topic: str, node_name: str) -> None:
    """Wait until a node publishes on a topic; any node, if the name is empty."""
    await _wait(ctx, [Wanted("publisher", topic, node_name)])


@action("wait_for_topic_subscription", anywhere=Ros2System)
async def wait_for_topic_subscription(ctx: ActionContext, topic: str, node_name: str) -> None:
    """Wait until a node subscribes to a topic; any node, if the name is empty."""
    await _wait(ctx, [Wanted("subscription", topic, node_name)])


@action("wait_for_service_server", anywhere=Ros2System)
async def wait_for_service_server(ctx: ActionContext, service: str, node_name: str) -> None:
    """Wait until a node serves a service; any node, if the name is empty."""
    await _wait(ctx, [Wanted("server", service, node_name)])


async def _wait(ctx: ActionContext, wanted: Sequence[Wanted]) -> None:
    if not wanted:
        raise ActionFailed("there is nothing to wait for: the list is empty")
    system = system_of(ctx)
    with failing(), telling(ctx, lambda: ", ".join(system.missing(wanted))):
        await meanwhile(ctx, system.wait_for(wanted))
