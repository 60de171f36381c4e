"""Topics, over real sessions and a router."""

import os
import time
from pathlib import Path

import anyio
import pytest

from seoro.bridges.ros2.errors import DefinitionMismatch, WrongType
from seoro.bridges.ros2.interfaces import InvalidPayload, InvalidValue, TypeStore, UnknownInterface
from seoro.bridges.ros2.topics import ReceivedPayload
from seoro.bridges.ros2.wire import PRESETS, Durability, InvalidName, Qos, RmwZenoh
from seoro.bridges.session import Bound, SessionError, publishing
from tests.bridges.ros2.systems import STRING, two_nodes, with_another_string

LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=2)


async def test_published_messages_are_received(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        here.subscribing("chatter", "std_msgs.msg.String") as subscription,
        there.publishing("/chatter", "std_msgs/String") as publication,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            publication.publish({"data": "one"})
            publication.publish({})
            first, second = await subscription.receive(), await subscription.receive()
    assert [subscription.decode(each).data for each in (first, second)] == ["one", ""]
    assert (first.sequence, second.sequence) == (1, 2)
    assert first.sent is not None and first.sent <= first.arrived
    assert first.sender == second.sender and len(first.sender) == 16
    assert first.type_hash == types.type_hash(STRING)
    assert (subscription.lost, subscription.missed) == (0, 0)


async def test_the_sender_is_the_publisher_of_the_graph(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        here.subscribing("/chatter", STRING) as subscription,
        there.publishing("/chatter", STRING) as publication,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            publication.publish({"data": "hello"})
            received = await subscription.receive()
            (publisher,) = await here.graph.wait_for(lambda seen: seen.publishers("/chatter"))
            token = here.graph.dialect.token(publisher)
            assert token is not None
            assert here.graph.dialect.gid(token) == received.sender


async def test_late_subscriptions_receive_latched_messages(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        there.publishing("map_name", STRING, LATCHED) as publication,
    ):
        for name in ("cellar", "hall", "attic"):
            publication.publish({"data": name})
        async with (
            here.subscribing("map_name", STRING, LATCHED) as subscription,
            here.subscribing("map_name", STRING) as volatile,
        ):
            with anyio.fail_after(30.0):
                names: list[str] = []
                while "attic" not in names:  # messages in transit arrive before
                    names.append((await subscription.message()).data)
                assert names[-2:] == ["hall", "attic"]
                await there.graph.wait_for(lambda seen: len(seen.subscriptions("/map_name")) == 2)
                publication.publish({"data": "roof"})
                assert (await subscription.message()).data == "roof"
                while (await volatile.message()).data != "roof":  # the same
                    pass


async def test_another_definition_of_the_type_is_reported(router: str, types: TypeStore, tmp_path: Path) -> None:
    theirs = with_another_string(types, tmp_path)
    async with (
        two_nodes(router, types, theirs=theirs) as (there, here),
        there.publishing("/chatter", STRING) as publication,
        here.subscribing("/chatter", STRING) as subscription,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            publication.publish({"data": "hello", "priority": 1})
            with pytest.raises(DefinitionMismatch) as caught:
                await subscription.message()
    assert (caught.value.theirs, caught.value.ours) == (theirs.type_hash(STRING), types.type_hash(STRING))
    assert "/chatter: the robot and seoro have different definitions of std_msgs/msg/String" in str(caught.value)


async def test_editions_of_packages_are_found_by_their_hashes(router: str, types: TypeStore) -> None:
    """Ranges have a variance in Jazzy, but not in Humble."""
    name, humble = "sensor_msgs/msg/Range", TypeStore.bundled("humble")
    async with (
        two_nodes(router, types, theirs=humble) as (there, here),
        there.publishing("/range", name) as publication,
        there.subscribing("/back", name) as back,
        here.subscribing("/range", name) as subscription,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            publication.publish({"range": 1.5})
            message = await subscription.message()
            assert message.range == 1.5
            assert not hasattr(message, "variance")
            await here.graph.wait_for(lambda seen: seen.subscriptions("/back"))
            async with here.publishing("/back", name) as answer:
                await answer.wait_for_subscription()
                answer.publish({"range": 2.5})
                assert (await back.message()).range == 2.5


async def test_messages_of_another_definition_are_not_published(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = with_another_string(types, tmp_path)
    async with (
        two_nodes(router, types, theirs=theirs) as (there, here),
        there.subscribing("/chatter", STRING),
    ):
        await here.graph.wait_for(lambda seen: seen.subscriptions("/chatter"), 30.0)
        with pytest.raises(DefinitionMismatch):
            async with here.publishing("/chatter", STRING):
                pass


async def test_late_subscribers_with_another_definition_are_reported(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = with_another_string(types, tmp_path)
    async with (
        two_nodes(router, types, theirs=theirs) as (there, here),
        here.publishing("/chatter", STRING) as ours,
    ):
        with pytest.raises(TimeoutError):
            await ours.wait_for_subscription(0.02)
        token = (
            "@ros2_lv/0/aa/1/2/MS/%/%/listener/%chatter/std_msgs::msg::dds_::String_/"
            f"{theirs.type_hash(STRING)}/1:2:1,10:,:,:,,"
        )
        async with there.system.session.token(token):
            await here.graph.wait_for(lambda seen: seen.subscriptions("/chatter"), 30.0)
            with pytest.raises(DefinitionMismatch, match="/chatter"):
                await ours.wait_for_subscription(0.02)


async def test_a_topic_of_another_type_is_refused(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (there, here), there.publishing("/chatter", STRING):
        await here.graph.wait_for(lambda seen: seen.publishers("/chatter"), 30.0)
        for use in (here.subscribing, here.publishing):
            with pytest.raises(WrongType, match="/chatter is of type std_msgs/msg/String, not std_msgs/msg/Int32"):
                async with use("/chatter", "std_msgs/msg/Int32"):
                    pass


async def test_topics_without_type_hashes_are_received(router: str, types: TypeStore) -> None:
    """Humble computes no hashes; its tokens contain other words."""
    dialect = RmwZenoh()
    key = dialect.key("/chatter", STRING, "TypeHashNotSupported")
    token = f"@ros2_lv/0/aa/1/2/MS/%/%/listener/%chatter/{key.partition('chatter/')[2]}/1:2:1,10:,:,:,,"
    async with (
        two_nodes(router, types) as (there, here),
        here.subscribing("/chatter", STRING) as subscription,
        publishing(there.system.session, key) as publisher,
        there.system.session.token(token),
    ):
        with anyio.fail_after(30.0):
            await publisher.wait_for_subscriber()
            publisher.put(types.encode(STRING, {"data": "humble"}), dialect.attachment(1, 1, bytes(16)))
            assert (await subscription.message()).data == "humble"
            await here.graph.wait_for(lambda seen: len(seen.subscriptions("/chatter")) == 2)
        async with (
            here.publishing("/chatter", STRING, LATCHED) as publication,
            there.subscribing("/chatter", STRING, LATCHED) as listener,
        ):
            publication.publish({"data": "anyone"})
            with anyio.fail_after(30.0):
                received = await listener.receive()
        assert (listener.decode(received).data, received.type_hash) == ("anyone", None)


async def test_messages_of_undefined_types_are_received_undecoded(router: str, types: TypeStore) -> None:
    token = "@ros2_lv/0/aa/1/2/MP/%/%/driver/%state/own_msgs::msg::dds_::State_/RIHS01_12/1:2:1,10:,:,:,,"
    key = "0/state/own_msgs::msg::dds_::State_/RIHS01_12"
    async with two_nodes(router, types) as (there, here), there.system.session.token(token):
        await here.graph.wait_for(lambda seen: seen.publishers("/state"), 30.0)
        async with (
            here.subscribing("/state", "own_msgs/msg/State") as subscription,
            publishing(there.system.session, key) as publisher,
        ):
            with anyio.fail_after(30.0):
                await publisher.wait_for_subscriber()
                publisher.put(b"\0\1\0\0\x2a")
                received = await subscription.receive()
        assert (received.payload, received.type_hash) == (b"\0\1\0\0\x2a", "RIHS01_12")
        assert (received.sent, received.sequence, received.sender) == (None, None, b"")
        with pytest.raises(UnknownInterface):
            subscription.decode(received)


async def test_invalid_uses_are_errors(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (_, here):
        with pytest.raises(UnknownInterface):
            async with here.subscribing("/chatter", "own_msgs/msg/State"):
                pass
        with pytest.raises(InvalidName):
            async with here.publishing("/2nd", STRING):
                pass
        async with here.publishing("/chatter", STRING) as publication:
            with pytest.raises(InvalidValue):
                publication.publish({"date": "x"})


async def test_an_invalid_payload_is_an_error(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        here.subscribing("/chatter", STRING) as subscription,
        there.publishing("/chatter", STRING) as publication,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            publication.send(b"\0\1\0\0\xff\0\0\0short")
            with pytest.raises(InvalidPayload):
                await subscription.message()
            publication.publish({"data": "fine"})
            assert (await subscription.message()).data == "fine"


async def test_messages_of_10_megabytes_arrive_complete(router: str, types: TypeStore) -> None:
    payload = bytes(range(256)) * 39063
    async with (
        two_nodes(router, types) as (there, here),
        here.subscribing("/blob", STRING) as subscription,
        there.publishing("/blob", STRING) as publication,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            received = None
            while received is None:  # a busy machine may drop some or all messages
                publication.send(payload)
                with anyio.move_on_after(1):
                    received = await subscription.receive()
    assert received.payload == payload


def resident() -> int:
    """Return the resident memory of this process [bytes]; tracemalloc would crash with threads of Zenoh."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


async def test_a_flood_of_messages_takes_bounded_memory_and_is_counted(router: str, types: TypeStore) -> None:
    count, payload = 300, bytes(1_000_000)
    bound = Bound(10, size=5_000_000)
    async with (
        two_nodes(router, types) as (there, here),
        here.subscribing("/blob", STRING, bound=bound) as subscription,
        there.publishing("/blob", STRING) as publication,
    ):
        with anyio.fail_after(30):
            await publication.wait_for_subscription()
            before = resident()
            for _ in range(count):
                publication.send(payload)
            grown = resident() - before
            received: list[ReceivedPayload] = []
            while True:  # messages in transit
                with anyio.move_on_after(0.5) as waiting:
                    received.append(await subscription.receive())
                if waiting.cancelled_caught:
                    break
            publication.send(b"the end")
            received.append(await subscription.receive())
    assert grown < 60_000_000
    assert len(received) < count / 2
    assert subscription.lost > 0
    assert len(received) + subscription.lost + subscription.missed == received[-1].sequence == count + 1


async def test_decoding_is_prepared_before_the_first_message(
    router: str, types: TypeStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepared: list[str] = []
    monkeypatch.setattr(TypeStore, "prepare", lambda _, name: prepared.append(name))
    async with two_nodes(router, types) as (_, here):
        async with here.subscribing("raw", STRING, is_decoded=False):
            assert prepared == []
        async with here.subscribing("chatter", "std_msgs.msg.String"):
            assert prepared == [STRING]


async def test_a_blocked_event_loop_loses_no_message(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        here.subscribing("/scan", STRING, bound=Bound(1000)) as subscription,
        there.publishing("/scan", STRING) as publication,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
            for _ in range(100):
                publication.send(bytes(5_800))
                time.sleep(0.005)  # the event loop is blocked meanwhile
            numbers = [(await subscription.receive()).sequence for _ in range(100)]
    assert numbers == list(range(1, 101))


async def test_reading_ends_with_the_subscription(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (_, here):
        async with here.subscribing("/chatter", STRING, PRESETS["sensor_data"]) as subscription:
            pass
        assert [received async for received in subscription] == []


async def test_endpoints_are_announced_while_they_exist(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (there, here):
        async with here.publishing("/out", STRING, LATCHED), here.subscribing("/in", STRING):
            (publisher,) = await there.graph.wait_for(lambda seen: seen.publishers("/out"), 30.0)
            (subscription,) = await there.graph.wait_for(lambda seen: seen.subscriptions("/in"), 30.0)
            assert publisher.qos == LATCHED
            assert subscription.node == here.node
            assert subscription.type_hash == types.type_hash(STRING)
        await there.graph.wait_for(lambda seen: not (seen.publishers("/out") or seen.subscriptions("/in")), 30.0)
        assert "/seoro" in there.graph.nodes()


async def test_publishing_after_the_end_is_an_error(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (_, here):
        async with here.publishing("/chatter", STRING) as publication:
            pass
        with pytest.raises(SessionError):
            publication.publish({"data": "late"})
