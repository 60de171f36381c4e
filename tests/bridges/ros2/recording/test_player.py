"""Playing bags, over real sessions and a router."""

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import anyio
import pytest

from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.interfaces import TypeStore, UnknownInterface
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.recording.errors import UnknownTopic, UnreadableBag
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bridges.ros2.recording.player import Playback, _offer, play
from seoro.bridges.ros2.recording.reader import open_bag
from seoro.bridges.ros2.recording.writer import write_bag
from seoro.bridges.ros2.topics import ReceivedPayload, Subscription
from seoro.bridges.ros2.wire import Qos, Reliability
from seoro.bridges.session import Bound
from seoro.errors import UsageError
from tests.bridges.ros2.recording.bags import CHATTER, LATCHED, SECOND, START, STRING, talk, text, write
from tests.bridges.ros2.systems import two_nodes, with_another_string

FAST = Playback(rate=1000)
MILLISECOND = SECOND // 1000  # [ns]


@asynccontextmanager
async def listening(
    router: str, types: TypeStore, topic: str = "/chatter", type_name: str = STRING
) -> AsyncIterator[tuple[RosNode, Subscription]]:
    """Yield a playing node, and a subscription of the robot."""
    with anyio.fail_after(30.0):
        async with (
            two_nodes(router, types) as (there, here),
            there.subscribing(topic, type_name, Qos(), Bound(1000)) as subscription,
        ):
            await here.graph.wait_for(lambda graph: graph.subscriptions(topic))
            yield here, subscription


async def take(subscription: Subscription, count: int) -> list[ReceivedPayload]:
    """Return the next messages."""
    return [await subscription.receive() for _ in range(count)]


async def test_recorded_messages_are_published_with_their_type_and_qos(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    latched = BagTopic("/map_name", STRING, CHATTER.type_hash, (LATCHED, Qos(Reliability.BEST_EFFORT, depth=7)))
    messages = [*talk(300), ("/map_name", talk(1)[0][1], SECOND)]
    bag = open_bag(await write(tmp_path / "bag", messages, CHATTER, latched))
    async with listening(router, types) as (here, subscription):
        assert await play(here, bag, FAST) == {"/chatter": 300, "/map_name": 1}
        received = await take(subscription, 300)
    assert [subscription.decode(each).data for each in received] == [str(number) for number in range(300)]
    assert subscription.missed == 0


async def test_publishers_offer_a_qos_for_all_recorded_publishers(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    topic = BagTopic("/chatter", STRING, CHATTER.type_hash, (LATCHED, Qos(Reliability.BEST_EFFORT, depth=7)))
    bag = open_bag(await write(tmp_path / "bag", talk(2, SECOND), topic))
    async with two_nodes(router, types) as (there, here), anyio.create_task_group() as tasks:
        tasks.start_soon(play, here, bag)
        (publisher,) = await there.graph.wait_for(lambda graph: graph.publishers("/chatter"), 30.0)
        tasks.cancel_scope.cancel()
    assert publisher.qos is not None
    assert (publisher.qos.is_reliable, publisher.qos.is_transient_local, publisher.qos.depth) == (True, True, 7)


def test_a_publisher_keeps_the_latched_messages_of_several() -> None:
    assert _offer((LATCHED, LATCHED, Qos())).depth == max(2 * LATCHED.depth, Qos().depth)
    assert _offer((replace(LATCHED, depth=1),) * 2).depth == 2


async def test_messages_are_played_at_their_times_and_at_a_rate(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    bag = open_bag(await write(tmp_path / "bag", talk(4, 200 * MILLISECOND), CHATTER))
    async with listening(router, types) as (here, subscription):
        started = time.time_ns()
        await play(here, bag, Playback(rate=4))
        received = await take(subscription, 4)
    for number, each in enumerate(received):
        assert each.arrived - started > number * 50 * MILLISECOND  # never early; busy machines are late


async def test_a_part_of_a_bag_is_played_from_an_offset(router: str, types: TypeStore, tmp_path: Path) -> None:
    other = BagTopic("/other", STRING, CHATTER.type_hash, (Qos(),))
    messages = [*talk(20), *(("/other", payload, time) for _, payload, time in talk(20))]
    bag = open_bag(await write(tmp_path / "bag", messages, CHATTER, other))
    async with listening(router, types) as (here, subscription):
        counts = await play(here, bag, Playback(("/chatter",), rate=1000, start_offset=1.5))
        assert counts == {"/chatter": 5}
        received = await take(subscription, 5)
    assert [subscription.decode(each).data for each in received] == [str(number) for number in range(15, 20)]


async def test_latched_messages_from_before_the_offset_are_played(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    latched = BagTopic("/map_name", STRING, CHATTER.type_hash, (LATCHED, LATCHED, Qos()))
    names = [("/map_name", text(name), number) for number, name in enumerate(("attic", "hall", "cellar"))]
    bag = open_bag(await write(tmp_path / "bag", [*names, *talk(20)], CHATTER, latched))
    async with listening(router, types, "/map_name") as (here, subscription):
        counts = await play(here, bag, Playback(rate=1000, start_offset=1.0))
        received = await take(subscription, 2)
    assert counts == {"/chatter": 10, "/map_name": 2}
    assert [subscription.decode(each).data for each in received] == ["hall", "cellar"]


async def test_the_clock_publishes_the_time_of_the_bag(router: str, types: TypeStore, tmp_path: Path) -> None:
    notes: list[str] = []
    clock = BagTopic("/clock", "rosgraph_msgs/msg/Clock", types.type_hash("rosgraph_msgs/msg/Clock"))
    recorded = ("/clock", types.encode(clock.type, {"clock": {"sec": 1}}), 0)
    bag = open_bag(await write(tmp_path / "bag", [recorded, *talk(11)], CHATTER, clock))
    async with listening(router, types, "/clock", clock.type) as (here, subscription):
        started = time.monotonic()
        await play(here, bag, Playback(rate=5, clock_rate=50), on_note=notes.append)
        most = (time.monotonic() - started) * 50 + 2  # one at the beginning, one at the end
        nanoseconds = [0]
        while nanoseconds[-1] < SECOND:  # the last is published after the last message of the bag
            (received,) = await take(subscription, 1)
            time_of_bag = subscription.decode(received).clock
            nanoseconds.append(time_of_bag.sec * SECOND + time_of_bag.nanosec - START)
    assert nanoseconds == sorted(nanoseconds)
    assert 2 <= len(nanoseconds) - 1 <= most
    assert notes == ["/clock of the bag is not played, since its time is published"]


async def test_types_defined_only_by_the_bag_are_played(router: str, types: TypeStore, tmp_path: Path) -> None:
    own = BagTopic("/own", "my_msgs/msg/Own", "RIHS01_" + "5" * 64, (LATCHED,))
    async with write_bag(tmp_path / "bag") as writer:
        writer.add_topic(own, "")
        writer.write("/own", b"\x00\x01\x00\x00\x07", START)
        writer.write("/own", b"\x00\x01\x00\x00\x08", START + SECOND // 10)
    bag = open_bag(tmp_path / "bag")
    async with two_nodes(router, types) as (there, here), anyio.create_task_group() as tasks:
        tasks.start_soon(play, here, bag, Playback(rate=0.1))
        (publisher,) = await there.graph.wait_for(lambda graph: graph.publishers("/own"), 30.0)
        async with there.subscribing("/own", own.type, LATCHED) as subscription:
            (received,) = await take(subscription, 1)
        tasks.cancel_scope.cancel()
    assert (publisher.type_hash, received.payload) == (own.type_hash, b"\x00\x01\x00\x00\x07")


async def test_an_undefined_type_is_refused_with_its_name(router: str, types: TypeStore, tmp_path: Path) -> None:
    async with write_bag(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/own", "my_msgs/msg/Own"), "")
    async with two_nodes(router, types) as (_, here):
        with pytest.raises(UnknownInterface, match="unknown package `my_msgs`"):
            await play(here, open_bag(tmp_path / "bag"))


async def test_subscribers_with_another_definition_are_refused(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = with_another_string(types, tmp_path / "definitions")
    bag = open_bag(await write(tmp_path / "bag", talk(1), CHATTER))
    async with two_nodes(router, types, theirs=theirs) as (there, here), there.subscribing("/chatter", STRING):
        await here.graph.wait_for(lambda graph: graph.subscriptions("/chatter"), 30.0)
        with pytest.raises(DefinitionMismatch, match="/chatter"):
            await play(here, bag)


async def test_a_damaged_bag_is_played_up_to_the_damage(router: str, types: TypeStore, tmp_path: Path) -> None:
    messages = [(CHATTER.name, text("x" * 100_000), number) for number in range(100)]
    bag = open_bag(await write(tmp_path / "bag", messages, CHATTER))
    file = tmp_path / "bag" / "bag_0.mcap"
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 0xFF
    file.write_bytes(content)
    async with two_nodes(router, types) as (_, here):
        with pytest.raises(UnreadableBag, match="is damaged"):
            await play(here, bag, FAST)


async def test_invalid_settings_are_refused(router: str, types: TypeStore, tmp_path: Path) -> None:
    bag = open_bag(await write(tmp_path / "bag", talk(21), CHATTER))
    async with two_nodes(router, types) as (_, here):
        with pytest.raises(UnknownTopic, match="no topic /chater"):
            await play(here, bag, Playback(("/chater",)))
        with pytest.raises(UsageError, match=r"the start offset 2\.5 s is after the end of .*bag \(2\.000 s\)"):
            await play(here, bag, Playback(start_offset=2.5))


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"rate": 0.0}, "invalid playback rate 0"),
        ({"clock_rate": -1.0}, "invalid clock rate -1"),
        ({"start_offset": float("nan")}, "invalid start offset nan s"),
    ],
)
def test_invalid_rates_and_offsets_are_refused(options: dict[str, float], problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        Playback(**options)  # type: ignore[arg-type]
