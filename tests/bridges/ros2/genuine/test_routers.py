"""Genuine nodes behind a router that restarts."""

from __future__ import annotations

import anyio
import pytest

from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2
from tests.routers import free_endpoint

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

STRING = "std_msgs/msg/String"


async def is_there(endpoint: str, name: str) -> None:
    """Wait until a node is in the graph, and its messages arrive."""
    async with connect(endpoint, dialect=RmwZenoh()) as system, system.node("watcher") as node:
        await node.graph.wait_for(lambda graph: name in graph.nodes(), DEADLINE)
        async with node.subscribing("/chatter", STRING) as chatter:
            with anyio.fail_after(DEADLINE):
                assert (await chatter.message()).data == "hello"


async def is_gone(endpoint: str, name: str) -> None:
    """Wait until a node has left the graph."""
    async with connect(endpoint, dialect=RmwZenoh()) as system:
        await system.graph.wait_for(lambda graph: name not in graph.nodes(), DEADLINE)


async def test_nodes_receive_messages_of_each_other(ros2: Ros2, router: str) -> None:
    async with ros2.node(router, "talker"), ros2.node(router, "listener") as listener:
        await listener.printed("received hello")


async def test_nodes_are_in_the_graph_after_a_restart_of_the_router_until_they_end(ros2: Ros2) -> None:
    endpoint = free_endpoint()
    async with ros2.router("seoro", endpoint) as router, ros2.node(endpoint, "talker"):
        await is_there(endpoint, "/talker")
        router.process.kill()
        await router.process.wait()
        async with ros2.router("seoro", endpoint):
            await is_there(endpoint, "/talker")
            async with ros2.node(endpoint, "listener") as listener:
                await listener.printed("received hello")


async def test_nodes_started_before_the_router_are_in_the_graph_until_they_end(ros2: Ros2) -> None:
    endpoint = free_endpoint()
    async with ros2.node(endpoint, "talker") as talker, ros2.router("seoro", endpoint):
        await is_there(endpoint, "/talker")
        talker.process.kill()
        await is_gone(endpoint, "/talker")
