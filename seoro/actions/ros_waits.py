"""Actions of `osc.ros` that wait for nodes, topics, services and their endpoints.

They end as soon as the entities are announced, without polling. An action that is cancelled before, for example by
`timeout`, logs the missing entities.
"""

from __future__ import annotations

from collections.abc import Sequence

from seoro.actions.reports import meanwhile
from seoro.actions.ros_support import as_action_failure, log_missing, system_of
from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Ros2System, Wanted
from seoro.runtime.functions.actions import action


@action("wait_for_nodes", anywhere=Ros2System)
async def wait_for_nodes(ctx: ActionContext, nodes: Sequence[str]) -> None:
    """Wait until all of the nodes exist."""
    await _wait(ctx, [Wanted("node", name) for name in nodes])


@action("wait_for_topics", anywhere=Ros2System)
async def wait_for_topics(ctx: ActionContext, topics: Sequence[str]) -> None:
    """Wait until each topic has a publisher or a subscription."""
    await _wait(ctx, [Wanted("topic", name) for name in topics])


@action("wait_for_services", anywhere=Ros2System)
async def wait_for_services(ctx: ActionContext, services: Sequence[str]) -> None:
    """Wait until each service has a server."""
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
        raise ActionFailed("the list is empty; expected at least one name")
    system = system_of(ctx)
    with as_action_failure(), log_missing(ctx, lambda: ", ".join(system.missing(wanted))):
        await meanwhile(ctx, system.wait_for(wanted))
