"""Communication with zenoh-ros2-sdk, another implementation of the rmw_zenoh protocol."""

import asyncio
import os
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.interfaces import Message, TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.recording import open_bag, play, record, write_bag
from seoro.bridges.ros2.wire import RmwZenoh

pytest.importorskip("zenoh_ros2_sdk", reason="zenoh-ros2-sdk is not installed")

PEER = Path(__file__).with_name("sdk_peer.py")
STRING = "std_msgs/msg/String"
ADD = "example_interfaces/srv/AddTwoInts"


class Peer:
    """A process with the other implementation."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    def write_line(self, *words: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write((" ".join(map(str, words)) + "\n").encode())

    async def read_line(self) -> list[str]:
        assert self._process.stdout is not None
        with anyio.fail_after(30.0):
            return (await self._process.stdout.readline()).decode().split()


@pytest.fixture
async def peer(router: str, tmp_path: Path) -> AsyncIterator[Peer]:
    environment = os.environ | {"HOME": str(tmp_path), "ZENOH_CONFIG_OVERRIDE": "scouting/delay=20"}
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        str(PEER),
        router.rpartition(":")[2],
        env=environment,
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
    )
    peer = Peer(process)
    try:
        assert await peer.read_line() == ["ready"]
        yield peer
    finally:
        process.kill()
        await process.wait()


@asynccontextmanager
async def our_node(router: str, types: TypeStore) -> AsyncIterator[RosNode]:
    async with connect(router, types=types) as system, system.node("seoro_test") as node:
        yield node


async def test_endpoints_of_the_peer_are_in_the_graph(router: str, types: TypeStore, peer: Peer) -> None:
    async with connect(router, types=types) as ours:
        graph = ours.graph
    assert ours.dialect == RmwZenoh(0)
    assert "/sdk_talker" in graph.nodes()
    assert graph.clients("/seoro_add")
    assert graph.topics() == {"/from_sdk": (STRING,), "/to_sdk": (STRING,)}
    assert graph.services() == {"/sdk_add": (ADD,)}
    (publisher,) = graph.publishers("/from_sdk")
    assert publisher.type_hash == types.type_hash(STRING)
    assert publisher.qos is not None and publisher.qos.is_reliable and publisher.qos.depth == 10


async def test_messages_of_the_peer_are_received(router: str, types: TypeStore, peer: Peer) -> None:
    async with our_node(router, types) as node, node.subscribing("/from_sdk", STRING) as subscription:
        with anyio.fail_after(30.0):
            await node.graph.wait_for(lambda seen: seen.publishers("/from_sdk"))
            received = None
            while received is None:  # it may not know of the subscription yet
                peer.write_line("publish", "hello")
                with anyio.move_on_after(0.2):
                    received = await subscription.receive()
    assert subscription.decode(received).data == "hello"
    assert received.sent is not None and 0 <= received.arrived - received.sent < 5e9
    assert len(received.sender) == 16


async def test_the_peer_receives_messages(router: str, types: TypeStore, peer: Peer) -> None:
    async with our_node(router, types) as node, node.publishing("/to_sdk", STRING) as publication:
        await publication.wait_for_subscription(30.0)
        publication.publish({"data": "servus"})
        assert await peer.read_line() == ["received", "servus"]


async def test_the_peer_serves_calls(router: str, types: TypeStore, peer: Peer) -> None:
    async with our_node(router, types) as node, node.calling("/sdk_add", ADD) as client:
        await client.wait_for_server(30.0)
        response = await client.call({"a": 20, "b": 22}, timeout=30)
        assert response.sum == 42
        assert await peer.read_line() == ["asked", "20", "22"]


async def test_calls_of_the_peer_are_served(router: str, types: TypeStore, peer: Peer) -> None:
    async def respond(request: Message) -> Mapping[str, Any]:
        return {"sum": request.a + request.b}

    async with our_node(router, types) as node, node.serving("/seoro_add", ADD, respond):
        peer.write_line("call", 3, 4)
        assert await peer.read_line() == ["called", "7"]


async def test_messages_of_the_peer_are_recorded_and_it_receives_played_ones(
    router: str, types: TypeStore, peer: Peer, tmp_path: Path
) -> None:
    async with our_node(router, types) as node:
        with anyio.fail_after(20):
            async with record(node, tmp_path / "bag", ["/from_sdk"]) as recording:
                await recording.wait_complete()
                while not recording.counts:  # until its publisher has found the subscription
                    peer.write_line("publish", "hello")
                    await anyio.sleep(0.05)
            recorded = open_bag(tmp_path / "bag")
            (topic,) = recorded.topics.values()
            assert topic.type_hash == types.type_hash(STRING)
            payloads = [message.payload for message in recorded.messages()]
            assert {types.decode(STRING, payload).data for payload in payloads} == {"hello"}

            async with write_bag(tmp_path / "other") as writer:
                writer.add_topic(replace(topic, name="/to_sdk"), types.schema(STRING))
                writer.write("/to_sdk", payloads[0], 0)
            await play(node, open_bag(tmp_path / "other"))
            assert await peer.read_line() == ["received", "hello"]
