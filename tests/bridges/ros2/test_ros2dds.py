"""DDS robots behind a fake of their bridge."""

import struct
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest

from seoro.bridges.ros2.errors import NoResponse, NoServiceServer
from seoro.bridges.ros2.interfaces import InvalidValue, Message, TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import PRESETS, Durability, Qos, Ros2Dds
from tests.bridges.ros2.fake_bridge import HEADER, STRING_HASH, FakeBridge
from tests.bridges.ros2.systems import ADD, STRING

TWIST = "geometry_msgs/msg/Twist"
LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)


@pytest.fixture
def endpoint(tmp_path: Path) -> str:
    return f"unixsock-stream/{tmp_path}/bridge.sock"


@pytest.fixture
def bridge(endpoint: str) -> Iterator[FakeBridge]:
    bridge = FakeBridge(endpoint)
    yield bridge
    bridge.close()


async def test_announcements_of_the_bridge_form_the_graph(
    bridge: FakeBridge, endpoint: str, types: TypeStore
) -> None:
    async with connect(endpoint, types=types) as system:
        graph = system.graph
        assert graph.dialect == Ros2Dds()
        assert graph.topics() == {"/chatter": (STRING,), "/cmd_vel": (TWIST,), "/map_name": (STRING,)}
        assert graph.services() == {"/add": (ADD,)}
        assert graph.nodes() == ()
        (chatter,) = graph.publishers("/chatter")
        assert (chatter.type_hash, chatter.qos) == (STRING_HASH, Qos(depth=10))


async def test_messages_of_the_robot_are_received(bridge: FakeBridge, endpoint: str, types: TypeStore) -> None:
    assert not bridge.robot_says("to nobody")
    async with (
        connect(endpoint, types=types) as system,
        system.node("seoro") as node,
        node.subscribing("chatter", STRING, PRESETS["sensor_data"]) as subscription,
    ):
        with anyio.fail_after(30.0):
            while not bridge.robot_says("hello"):
                await anyio.sleep(0.01)
            received = await subscription.receive()
    assert subscription.decode(received).data == "hello"
    assert (received.sent, received.sequence, received.sender) == (None, None, b"")


async def test_latched_messages_of_the_robot_are_received(
    bridge: FakeBridge, endpoint: str, types: TypeStore
) -> None:
    bridge.robot_latches("cellar")
    bridge.robot_latches("hall")
    async with (
        connect(endpoint, types=types) as system,
        system.node("seoro") as node,
        node.subscribing("map_name", STRING, LATCHED) as subscription,
    ):
        with anyio.fail_after(30.0):
            assert (await subscription.message()).data == "hall"


async def test_the_robot_receives_published_messages(bridge: FakeBridge, endpoint: str, types: TypeStore) -> None:
    async with (
        connect(endpoint, types=types) as system,
        system.node("seoro") as node,
        node.publishing("/cmd_vel", TWIST) as publication,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            publication.publish({"linear": {"x": 0.25}})
            while not bridge.arrived:
                await anyio.sleep(0.01)
    assert bridge.arrived == [(HEADER + struct.pack("<6d", 0.25, 0, 0, 0, 0, 0), None)]


async def test_services_of_the_robot_are_called(bridge: FakeBridge, endpoint: str, types: TypeStore) -> None:
    async with (
        connect(endpoint, types=types) as system,
        system.node("seoro") as node,
        node.calling("/add", ADD) as client,
    ):
        assert (await client.call({"a": 40, "b": 2}, timeout=30)).sum == 42
        with pytest.raises(InvalidValue):
            await client.call({"c": 2}, timeout=30)
        async with node.calling("/nothing", ADD) as other:
            with pytest.raises(NoServiceServer):
                await other.call({}, timeout=30)


async def test_requests_dropped_by_the_bridge_time_out(
    bridge: FakeBridge, endpoint: str, types: TypeStore, tmp_path: Path
) -> None:
    """Services have no hashes behind a bridge: with a wrong definition, the robot just never responds."""
    file = tmp_path / "example_interfaces" / "srv" / "AddTwoInts.srv"
    file.parent.mkdir(parents=True)
    file.write_text("int8 a\n---\nint8 sum\n")
    async with (
        connect(endpoint, types=types.add_folder(tmp_path)) as system,
        system.node("seoro") as node,
        node.calling("/add", ADD) as client,
    ):
        with pytest.raises(NoResponse, match=r"no response from /add within 0.05 s"):
            await client.call({"a": 1}, timeout=0.05)


async def test_services_of_seoro_are_served(bridge: FakeBridge, endpoint: str, types: TypeStore) -> None:
    """The bridge sends and receives plain CDR."""

    async def add(request: Message) -> dict[str, int]:
        return {"sum": request.a + request.b}

    async with (
        connect(endpoint, types=types) as system,
        system.node("seoro") as node,
        node.serving("/ours", ADD, add),
        connect(endpoint, types=types) as robot,
    ):
        response = await robot.session.query("ours", HEADER + struct.pack("<qq", 3, 4), 5)
    assert response == HEADER + struct.pack("<q", 7)


async def test_endpoints_are_announced_as_by_another_bridge(
    bridge: FakeBridge, endpoint: str, types: TypeStore
) -> None:
    async with (
        connect(endpoint, types=types) as system,
        system.node("seoro") as node,
        node.publishing("/cmd_vel", TWIST, PRESETS["sensor_data"]),
        node.subscribing("/chatter", STRING, LATCHED),
        node.calling("/add", ADD),
    ):
        beginning = f"@/{system.session.identity}/@ros2_lv"
        expected = {
            f"{beginning}/MP/cmd_vel/geometry_msgs§msg§Twist/:0:0:0,5:typehash={types.type_hash(TWIST)};",
            f"{beginning}/MS/chatter/std_msgs§msg§String/:1:1:0,1:typehash={STRING_HASH};",
            f"{beginning}/SC/add/example_interfaces§srv§AddTwoInts",
        }
        with anyio.fail_after(30.0):
            while not expected <= set(bridge.announced):
                await anyio.sleep(0.01)
        assert all(bridge.announced[token] for token in expected)
    with anyio.fail_after(30.0):
        while any(bridge.announced[token] for token in expected):
            await anyio.sleep(0.01)


async def test_names_of_a_robot_start_with_its_namespace(endpoint: str, types: TypeStore) -> None:
    bridge = FakeBridge(endpoint, "bot1/")
    try:
        async with connect(endpoint, types=types) as system:
            assert set(system.graph.topics()) == {"/bot1/chatter", "/bot1/cmd_vel", "/bot1/map_name"}
            assert set(system.graph.services()) == {"/bot1/add"}
    finally:
        bridge.close()
