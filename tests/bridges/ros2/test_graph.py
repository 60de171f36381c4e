"""Graphs of ROS 2 systems, by real tokens over a router."""

import asyncio
import sys
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path

import anyio
import pytest

import seoro.bridges.ros2.graph as graph_module
from seoro.bridges.ros2.errors import NoResponse, NoSystem
from seoro.bridges.ros2.graph import RosGraph, find_graph, open_graph, types_of
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import Dialect, RmwZenoh, Ros2Dds
from seoro.bridges.session import AsyncSession, open_session
from seoro.errors import BackendError, UsageError
from tests.bridges.ros2.systems import ADD, STRING, two_nodes
from tests.routers import as_if_elsewhere, free_endpoint

ALONE = Path(__file__).with_name("alone.py")
HASH = "RIHS01_12"
TALKER = "@ros2_lv/0/aa/1/1/NN/%/%robot/talker"
BRIDGE = "@/bb/@ros2_lv/MP/chatter/std_msgs§msg§String/:1:0:0,10"


def endpoint(kind: str, number: int, name: str, dds_type: str) -> str:
    name = name.replace("/", "%")
    return f"@ros2_lv/0/aa/1/{number}/{kind}/%/%robot/talker/{name}/{dds_type}/{HASH}/1:2:1,10:,:,:,,"


@asynccontextmanager
async def tokens(router: str, *keys: str) -> AsyncIterator[AsyncSession]:
    """Announce tokens by a session."""
    async with open_session(connect=router) as session, AsyncExitStack() as stack:
        for key in keys:
            await stack.enter_async_context(session.token(key))
        async with open_session(connect=router) as other:
            for key in keys:
                while not await other.list_tokens(key, 5):
                    pass
            yield session
            await stack.aclose()
            for key in keys:
                while await other.list_tokens(key, 5):
                    pass


@asynccontextmanager
async def graph_of(router: str, *keys: str) -> AsyncIterator[RosGraph]:
    """Yield the graph of a system with given tokens."""
    async with (
        tokens(router, *keys),
        open_session(connect=router) as session,
        open_graph(session, RmwZenoh()) as graph,
    ):
        yield graph


async def test_a_graph_is_complete_when_it_is_opened(router: str) -> None:
    keys = [endpoint("MP", number, f"/topic{number}", "a_msgs::msg::dds_::A_") for number in range(300)]
    async with tokens(router, TALKER, *keys):
        for _ in range(3):
            async with open_session(connect=router) as session, open_graph(session, RmwZenoh()) as graph:
                assert len(graph.topics()) == len(keys)
                assert graph.nodes() == ("/robot/talker",)


async def test_nodes_and_endpoints_have_names_and_types(router: str) -> None:
    keys = (
        endpoint("MP", 2, "/chatter", "std_msgs::msg::dds_::String_"),
        endpoint("MS", 3, "/chatter", "std_msgs::msg::dds_::String_"),
        endpoint("MS", 4, "/mixed", "std_msgs::msg::dds_::String_"),
        endpoint("MP", 5, "/mixed", "std_msgs::msg::dds_::Int32_"),
        endpoint("SS", 6, "/add", "example_interfaces::srv::dds_::AddTwoInts_"),
        endpoint("SC", 7, "/reset", "std_srvs::srv::dds_::Empty_"),
        endpoint("SS", 8, "/spin/_action/send_goal", "nav2_msgs::action::dds_::Spin_SendGoal_"),
        endpoint("MP", 9, "/spin/_action/status", "action_msgs::msg::dds_::GoalStatusArray_"),
    )
    async with graph_of(router, TALKER, *keys) as graph:
        assert graph.topics() == {"/chatter": (STRING,), "/mixed": ("std_msgs/msg/Int32", STRING)}
        assert set(graph.topics(hidden=True)) == {"/chatter", "/mixed", "/spin/_action/status"}
        assert graph.services() == {"/add": (ADD,)}
        assert set(graph.services(hidden=True)) == {"/add", "/spin/_action/send_goal"}
        assert graph.actions() == {"/spin": ("nav2_msgs/action/Spin",)}
        (server,) = graph.action_servers("/spin")
        assert (server.type, server.node and server.node.full_name) == (
            "nav2_msgs/action/Spin",
            "/robot/talker",
        )
        assert types_of((*graph.publishers("/chatter"), *graph.subscriptions("/chatter"))) == (STRING,)
        assert graph.publishers("/nothing") == graph.subscriptions("/nothing") == ()
        assert types_of(graph.servers("/add")) == (ADD,)
        assert graph.servers("/reset") == ()
        assert len(graph.clients("/reset")) == 1
        assert graph.topics()["/mixed"] == ("std_msgs/msg/Int32", "std_msgs/msg/String")


async def test_parts_of_announced_actions_have_types(router: str) -> None:
    token = "@/bb/@ros2_lv/AS/bot1§spin/nav2_msgs§action§Spin"
    async with (
        tokens(router, token),
        open_session(connect=router) as session,
        open_graph(session, Ros2Dds()) as graph,
    ):
        assert graph.actions() == {"/bot1/spin": ("nav2_msgs/action/Spin",)}
        part = "/bot1/spin/_action"
        assert types_of(graph.servers(f"{part}/send_goal")) == ("nav2_msgs/action/Spin_SendGoal",)
        assert types_of(graph.servers(f"{part}/get_result")) == ("nav2_msgs/action/Spin_GetResult",)
        assert types_of(graph.servers(f"{part}/cancel_goal")) == ("action_msgs/srv/CancelGoal",)
        assert types_of(graph.publishers(f"{part}/feedback")) == ("nav2_msgs/action/Spin_FeedbackMessage",)
        assert types_of(graph.publishers(f"{part}/status")) == ("action_msgs/msg/GoalStatusArray",)
        assert graph.servers(f"{part}/other") == graph.servers("/bot1/spin") == ()


async def test_appearing_and_leaving_endpoints_change_the_graph(router: str) -> None:
    async with open_session(connect=router) as session, open_graph(session, RmwZenoh()) as graph:
        assert graph.nodes() == ()
        with anyio.fail_after(30.0):
            async with tokens(router, TALKER, endpoint("MP", 2, "/chatter", "std_msgs::msg::dds_::String_")):
                await graph.wait_for(lambda seen: seen.publishers("/chatter"))
                await graph.wait_for(lambda seen: "/robot/talker" in seen.nodes())
            await graph.wait_for(lambda seen: not seen.publishers("/chatter") and not seen.nodes())


async def test_too_many_endpoints_are_an_error(router: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graph_module, "MAX_TOKENS", 3)
    keys = [endpoint("MP", number, f"/topic{number}", "a_msgs::msg::dds_::A_") for number in range(3)]
    async with tokens(router, *keys):
        with pytest.raises(BackendError, match=r"too many nodes and endpoints \(limit: 3\)"):
            async with open_session(connect=router) as session, open_graph(session, RmwZenoh()):
                pass
    async with open_session(connect=router) as session:
        with pytest.raises(ExceptionGroup) as caught:
            async with open_graph(session, RmwZenoh()), tokens(router, *keys):
                await anyio.sleep_forever()
        assert caught.group_contains(BackendError, match="too many nodes and endpoints")


async def test_waiting_for_a_graph_change_times_out(router: str) -> None:
    async with open_session(connect=router) as session, open_graph(session, RmwZenoh()) as graph:
        with pytest.raises(TimeoutError):
            await graph.wait_for(RosGraph.nodes, timeout=0.02)


async def test_a_killed_node_leaves_the_graph(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (_, here),
        here.calling("/wait", "std_srvs/srv/Empty") as client,
        here.subscribing("/chatter", STRING) as subscription,
        alone(router) as process,
    ):
        graph = here.graph
        await graph.wait_for(lambda seen: seen.servers("/wait"), 30.0)
        assert "/alone" in graph.nodes()
        with anyio.fail_after(30.0):
            assert (await subscription.message()).data == "still here"
            call = asyncio.create_task(client.call({}, timeout=30))
            await anyio.sleep(0.1)  # until the request is there
            process.kill()
            with pytest.raises(NoResponse, match="disappeared"):
                await call
            await graph.wait_for(lambda seen: "/alone" not in seen.nodes())
            await graph.wait_for(lambda seen: not (seen.publishers("/chatter") or seen.servers("/wait")))


@asynccontextmanager
async def alone(router: str) -> AsyncIterator[asyncio.subprocess.Process]:
    """Yield a node in its own process."""
    process = await asyncio.create_subprocess_exec(sys.executable, str(ALONE), router)
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()


@pytest.mark.more
async def test_the_graph_is_restored_after_a_restart_of_the_router(types: TypeStore) -> None:
    router = free_endpoint()
    async with AsyncExitStack() as stack:
        hub = AsyncExitStack()
        await hub.enter_async_context(open_session(listen=router, gossip=True))
        there, here = await stack.enter_async_context(two_nodes(as_if_elsewhere(router), types))
        publication = await stack.enter_async_context(there.publishing("/chatter", STRING))
        subscription = await stack.enter_async_context(here.subscribing("/chatter", STRING))
        graph = here.graph
        await graph.wait_for(lambda seen: "/robot" in seen.nodes(), 30.0)
        await hub.aclose()
        await graph.wait_for(lambda seen: not seen.publishers("/chatter"), 30.0)
        await hub.enter_async_context(open_session(listen=router, gossip=True))
        stack.push_async_callback(hub.aclose)
        await graph.wait_for(lambda seen: seen.publishers("/chatter") and "/robot" in seen.nodes(), 30.0)
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            publication.publish({"data": "again"})
            assert (await subscription.message()).data == "again"


async def dialect_at(router: str, timeout: float = 1) -> Dialect:
    async with open_session(connect=router) as session, find_graph(session, 0, timeout) as graph:
        return graph.dialect


async def test_the_dialect_of_a_router_is_detected(router: str) -> None:
    async with tokens(router, TALKER):
        assert await dialect_at(router) == RmwZenoh(0)
    async with tokens(router, BRIDGE):
        assert await dialect_at(router) == Ros2Dds()
    async with tokens(router, BRIDGE, TALKER):
        with pytest.raises(UsageError, match="both rmw_zenoh and a bridge") as refused:
            await dialect_at(router)
        assert "`--dialect ros2dds`" in refused.value.help


async def test_detecting_the_dialect_waits_for_a_system(router: str) -> None:
    looking = asyncio.create_task(dialect_at(router, 5))
    await anyio.sleep(0.05)
    async with tokens(router, TALKER):
        assert await looking == RmwZenoh(0)


async def test_a_domain_without_nodes_is_reported_with_other_domains(router: str, types: TypeStore) -> None:
    with pytest.raises(NoSystem, match="no node of rmw_zenoh in domain 0, and no bridge; is this the router"):
        await dialect_at(router, 0.02)
    async with connect(router, types=types, dialect=RmwZenoh(7)) as system, system.node():
        with pytest.raises(NoSystem, match="nodes are in domain 7"):
            await dialect_at(router, 0.02)
    async with tokens(router, f"@ros2_lv/{'9' * 5000}/aa/1/1/NN/%/%/hostile"):
        with pytest.raises(NoSystem, match="no node of rmw_zenoh in domain 0, and no bridge; is this the router"):
            await dialect_at(router, 0.02)


async def test_connecting_without_a_router_fails(types: TypeStore, tmp_path: Path) -> None:
    with pytest.raises(NoSystem, match=r"cannot connect to unixsock-stream.*: no router and no bridge"):
        async with connect(f"unixsock-stream/{tmp_path}/nobody.sock", types=types):
            pass
    with pytest.raises(UsageError, match="'localhost' is an invalid endpoint"):
        async with connect("localhost", types=types):
            pass
