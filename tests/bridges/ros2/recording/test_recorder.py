"""Recording, over real sessions and a router."""

import errno
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import anyio
import pytest
import yaml
from rosbags.rosbag2 import Reader

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.recording import recorder
from seoro.bridges.ros2.recording.errors import RecordingFailed, RefusedRecording
from seoro.bridges.ros2.recording.mcap_file import McapFile
from seoro.bridges.ros2.recording.reader import Bag, open_bag
from seoro.bridges.ros2.recording.recorder import Recording, record
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import Endpoint, InvalidName, Kind, Qos, RmwZenoh, Ros2Dds
from seoro.bridges.session import Bound
from tests.bridges.ros2.recording.bags import CHATTER, LATCHED, SCAN, SECOND, STRING, TYPES
from tests.bridges.ros2.systems import two_nodes, with_another_string

PATIENCE = 30  # [s]


@asynccontextmanager
async def limited() -> AsyncIterator[None]:
    """Fail if the block takes too long."""
    with anyio.fail_after(PATIENCE):
        yield


def texts(bag: Bag, topic: str = "/chatter") -> list[str]:
    """Return the texts of the messages of a topic."""
    return [TYPES.decode(STRING, message.payload).data for message in bag.messages({topic})]


def custom_data(folder: Path) -> Mapping[str, str]:
    """Return the notes of a bag."""
    information = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    return information["custom_data"] or {}


async def talk_to(publication: Publication, *texts: str) -> None:
    """Publish texts as soon as the topic has a subscription."""
    await publication.wait_for_subscription()
    for text in texts:
        publication.publish({"data": text})


async def recorded(recording: Recording, count: int) -> None:
    """Wait until a number of messages has been recorded."""
    while sum(recording.counts.values()) < count:
        await anyio.sleep(0.002)


async def test_topics_are_recorded_with_type_hash_and_qos(router: str, types: TypeStore, tmp_path: Path) -> None:
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        there.publishing("/scan", SCAN, LATCHED) as scan,
    ):
        scan.publish({"ranges": [1.0]})
        async with record(here, tmp_path / "bag", ["chatter", "/scan"]) as recording:
            await recording.wait_complete()
            await talk_to(chatter, "one", "two")
            await recorded(recording, 3)
    bag = open_bag(tmp_path / "bag")
    assert texts(bag) == ["one", "two"]
    assert bag.topics["/chatter"].type_hash == CHATTER.type_hash
    assert bag.topics["/scan"].qos == (LATCHED,)
    assert bag.topics["/scan"].count == 1
    assert all(0 <= message.received - message.sent < SECOND for message in bag.messages())
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 3


async def test_the_recorder_lists_missing_topics_until_all_exist(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        AsyncExitStack() as robot,
        record(here, tmp_path / "bag", ["/chatter", "/scan"]) as recording,
    ):
        assert list(recording.missing) == ["/chatter", "/scan"]
        await robot.enter_async_context(there.publishing("/scan", SCAN))
        while list(recording.missing) != ["/chatter"]:
            await anyio.sleep(0.002)
        chatter = await robot.enter_async_context(there.publishing("/chatter", STRING))
        await recording.wait_complete()
        assert [*recording.missing, "/", *recording.topics] == ["/", "/scan", "/chatter"]
        await talk_to(chatter, "late")
        await recorded(recording, 1)
    assert texts(open_bag(tmp_path / "bag")) == ["late"]


async def test_a_lost_publisher_is_reported_and_noted_in_the_bag(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    notes: list[str] = []
    async with limited(), two_nodes(router, types) as (there, here), AsyncExitStack() as robot:
        chatter = await robot.enter_async_context(there.publishing("/chatter", STRING))
        async with record(here, tmp_path / "bag", ["/chatter"], on_note=notes.append) as recording:
            await recording.wait_complete()
            await talk_to(chatter, "before")
            await robot.aclose()
            while len(notes) < 1:
                await anyio.sleep(0.002)
            async with there.publishing("/chatter", STRING) as again:
                await talk_to(again, "after")
                await recorded(recording, 2)
                while len(notes) < 2:
                    await anyio.sleep(0.002)
    assert notes[:2] == ["/chatter has lost its publisher, /robot", "/chatter has a publisher again"]
    assert texts(open_bag(tmp_path / "bag")) == ["before", "after"]
    assert custom_data(tmp_path / "bag")["notes"].splitlines() == notes


async def test_a_pattern_records_new_topics_and_hidden_ones_on_request_only(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        there.publishing("/robot1/chatter", STRING),
        there.publishing("/robot1/_hidden", STRING),
        there.publishing("/other", STRING),
        record(here, tmp_path / "few", pattern="/robot1/.*") as few,
        record(here, tmp_path / "all", pattern="/robot1/.*", hidden=True) as everything,
    ):
        await few.wait_complete()
        async with there.publishing("/robot1/scan", SCAN):
            while "/robot1/scan" not in few.topics or "/robot1/scan" not in everything.topics:
                await anyio.sleep(0.002)
        assert sorted(few.topics) == ["/robot1/chatter", "/robot1/scan"]
        assert sorted(everything.topics) == ["/robot1/_hidden", "/robot1/chatter", "/robot1/scan"]


async def test_messages_have_the_time_of_the_clock_on_request(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    notes: list[str] = []
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        record(here, tmp_path / "bag", ["/chatter"], use_sim_time=True, on_note=notes.append) as recording,
    ):
        assert recording.missing == ("/clock", "/chatter")
        async with there.publishing("/clock", "rosgraph_msgs/msg/Clock") as clock:
            await clock.wait_for_subscription()
            clock.publish({"clock": {"sec": 12, "nanosec": 500_000_000}})
            await recording.wait_complete()
            await talk_to(chatter, "at twelve")
            await recorded(recording, 1)
            clock.publish({"clock": {"sec": 3}})
            while not notes:
                await anyio.sleep(0.002)
            chatter.publish({"data": "at three"})
            await recorded(recording, 2)
    messages = open_bag(tmp_path / "bag").messages({"/chatter"})
    assert [(message.received, message.sent) for message in messages] == [
        (3 * SECOND, 3 * SECOND),
        (12 * SECOND + SECOND // 2, 12 * SECOND + SECOND // 2),
    ]
    assert notes == ["/clock jumped back from 12.500 s to 3.000 s"]


async def test_topics_of_unknown_definitions_are_recorded_without_definition(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = with_another_string(types, tmp_path / "definitions")
    notes: list[str] = []
    async with (
        limited(),
        two_nodes(router, types, theirs=theirs) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        record(here, tmp_path / "bag", ["/chatter"], on_note=notes.append) as recording,
    ):
        await recording.wait_complete()
        await talk_to(chatter, "theirs")
        await recorded(recording, 1)
    assert notes[0].startswith(
        "/chatter is recorded without the definition of std_msgs/msg/String: the definitions of the robot"
    )
    with Reader(tmp_path / "bag") as reader:
        (connection,) = reader.connections
        assert (connection.digest, connection.msgdef.data) == (theirs.type_hash(STRING), "")
        assert connection.msgcount == 1


async def test_all_received_messages_are_recorded_at_the_end(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        record(here, tmp_path / "bag", ["/chatter"]) as recording,
    ):
        await recording.wait_complete()
        await talk_to(chatter, *map(str, range(20)))
        time.sleep(0.2)  # all messages arrive while the event loop is blocked
    assert texts(open_bag(tmp_path / "bag")) == [str(number) for number in range(20)]


async def test_messages_of_the_known_definition_only_are_recorded(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs, notes = with_another_string(types, tmp_path / "definitions"), list[str]()
    async with (
        limited(),
        two_nodes(router, types, theirs=theirs) as (there, here),
        connect(router, types=types, dialect=RmwZenoh()) as other,
        other.node("other") as another,
        there.publishing("/chatter", STRING) as strange,
        another.publishing("/chatter", STRING) as chatter,
    ):
        await here.graph.wait_for(lambda graph: len(graph.publishers("/chatter")) == 2)
        async with record(here, tmp_path / "bag", ["/chatter"], on_note=notes.append) as recording:
            await recording.wait_complete()
            await talk_to(strange, "theirs")
            await talk_to(chatter, "ours")
            await recorded(recording, 1)
            while not notes:
                await anyio.sleep(0.002)
    assert notes == [
        "/chatter: messages with another definition of std_msgs/msg/String are not recorded"
        f" ({theirs.type_hash(STRING)}; recorded: {types.type_hash(STRING)})"
    ]
    assert texts(open_bag(tmp_path / "bag")) == ["ours"]


async def test_topics_with_invalid_names_are_skipped_with_a_note(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    notes: list[str] = []
    async with limited(), two_nodes(router, types) as (there, here), there.publishing("/good", STRING):
        session, number = there.node.session, there.system.number()
        odd = Endpoint(Kind.PUBLISHER, "/odd-name", STRING, session, CHATTER.type_hash, Qos(), number, there.node)
        token = there.graph.dialect.token(odd)
        assert token is not None
        async with there.system.session.token(token):
            await here.graph.wait_for(lambda graph: graph.publishers("/odd-name"))
            async with record(here, tmp_path / "bag", pattern=".*", on_note=notes.append) as recording:
                while not notes or not recording.topics:
                    await anyio.sleep(0.002)
    assert notes[0].startswith(
        "/odd-name is not recorded: '/odd-name': invalid part 'odd-name': expected letters, digits and '_'"
    )
    assert recording.topics == ("/good",)


async def test_messages_lost_in_transit_are_reported_counted_and_noted(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    notes: list[str] = []
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        record(here, tmp_path / "bag", ["/chatter"], on_note=notes.append) as recording,
    ):
        await recording.wait_complete()
        await talk_to(chatter, "1", "2")
        for _ in range(3):
            next(chatter._numbers)  # simulates drops on a congested link
        await talk_to(chatter, "6")
        next(chatter._numbers)
        await talk_to(chatter, "8")
        await recorded(recording, 4)
    assert recording.missed == {"/chatter": 4}
    assert notes == ["/chatter: messages are lost in transit, first number 3"]
    noted = custom_data(tmp_path / "bag")
    assert (noted["missed"], noted["notes"]) == ("4 of /chatter", notes[0])


async def test_dropped_messages_are_reported_counted_and_noted(
    router: str, types: TypeStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "WAITING", Bound(3))
    notes: list[str] = []
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        record(here, tmp_path / "bag", ["/chatter"], on_note=notes.append) as recording,
    ):
        await recording.wait_complete()
        await chatter.wait_for_subscription()
        for number in range(200):
            chatter.publish({"data": str(number)})
        time.sleep(0.2)  # the event loop is blocked: messages arrive unread
        await recorded(recording, 3)
    lost = recording.lost["/chatter"]
    assert lost + recording.counts["/chatter"] == 200
    assert notes == ["/chatter: messages are dropped, since they arrive faster than the disk writes"]
    assert custom_data(tmp_path / "bag")["lost"] == f"{lost} of /chatter"
    assert len(texts(open_bag(tmp_path / "bag"))) == recording.counts["/chatter"]


async def test_a_full_disk_ends_the_recording_with_an_error(
    router: str, types: TypeStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(file: McapFile) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(McapFile, "flush", refuse)
    with pytest.raises(RecordingFailed, match=r"bag_0\.mcap any more: No space left on device"):
        async with (
            limited(),
            two_nodes(router, types) as (there, here),
            there.publishing("/chatter", STRING) as chatter,
            record(here, tmp_path / "bag", ["/chatter"]) as recording,
        ):
            await recording.wait_complete()
            await talk_to(chatter, "hello")
            await anyio.sleep_forever()


async def test_a_cancelled_recording_leaves_an_intact_bag(router: str, types: TypeStore, tmp_path: Path) -> None:
    async with (
        limited(),
        two_nodes(router, types) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
    ):
        with anyio.CancelScope() as scope:
            async with record(here, tmp_path / "bag", ["/chatter"]) as recording:
                await recording.wait_complete()
                await talk_to(chatter, "last")
                await recorded(recording, 1)
                scope.cancel()
                await anyio.sleep_forever()
        await here.graph.wait_for(lambda graph: not graph.subscriptions("/chatter"))
    bag = open_bag(tmp_path / "bag")
    assert (texts(bag), bag.is_cut_off) == (["last"], False)


async def test_topics_behind_a_bridge_for_dds_are_recorded(router: str, types: TypeStore, tmp_path: Path) -> None:
    async with (
        limited(),
        two_nodes(router, types, dialect=Ros2Dds()) as (there, here),
        there.publishing("/chatter", STRING) as chatter,
        record(here, tmp_path / "bag", ["/chatter"]) as recording,
    ):
        await recording.wait_complete()
        await talk_to(chatter, "hello")
        await recorded(recording, 1)
    bag = open_bag(tmp_path / "bag")
    assert texts(bag) == ["hello"]
    assert bag.topics["/chatter"].type_hash == CHATTER.type_hash


async def test_invalid_requests_are_refused_before_a_folder_is_created(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    async def begin(*topics: str, pattern: str = "") -> None:
        async with record(here, tmp_path / "bag", topics, pattern=pattern):
            pass

    async with two_nodes(router, types) as (_, here):
        with pytest.raises(RefusedRecording, match="no topics to record"):
            await begin()
        with pytest.raises(
            RefusedRecording, match=r"/a/_action/status is a hidden topic, and hidden topics are not"
        ):
            await begin("/a/_action/status")
        with pytest.raises(InvalidName):
            await begin("/not a topic")
        with pytest.raises(RefusedRecording, match=r"the pattern '\(' is an invalid regular expression"):
            await begin(pattern="(")
    assert not (tmp_path / "bag").exists()
