import shutil
from pathlib import Path
from random import Random

import pytest
import yaml
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.interfaces import Qos as RosbagsQos
from rosbags.interfaces import QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from seoro.bridges.ros2.recording.errors import UnknownTopic, UnreadableBag
from seoro.bridges.ros2.recording.mcap_file import Compression
from seoro.bridges.ros2.recording.reader import open_bag, repair_bag
from seoro.bridges.ros2.wire import Durability, Qos
from tests.bridges.ros2.recording.bags import (
    CHATTER,
    LATCHED,
    SCANS,
    SECOND,
    START,
    STRING,
    TYPES,
    talk,
    text,
    write,
)

FOREVER = QosTime(9_223_372_036, 854_775_807)
OFFERED = RosbagsQos(
    QosHistory.KEEP_LAST,
    1,
    QosReliability.RELIABLE,
    QosDurability.TRANSIENT_LOCAL,
    FOREVER,
    FOREVER,
    QosLiveliness.AUTOMATIC,
    FOREVER,
    False,
)


def by_rosbags(folder: Path, storage: StoragePlugin, mode: CompressionMode = CompressionMode.NONE) -> Path:
    """Write a bag of three messages of `/chatter` by rosbags."""
    writer = Writer(folder, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(
            CHATTER.name,
            STRING,
            msgdef=TYPES.schema(STRING),
            rihs01=CHATTER.type_hash,
            offered_qos_profiles=[OFFERED],
        )
        for _, payload, time in talk(3):
            writer.write(connection, START + time, payload)
    return folder


async def test_messages_are_read_in_the_order_of_their_reception(tmp_path: Path) -> None:
    late_first = sorted(talk(2000, 1000), key=lambda message: message[2] % 7)
    bag = open_bag(await write(tmp_path / "bag", late_first, CHATTER))
    times = [message.received - START for message in bag.messages()]
    assert times == [time for _, _, time in talk(2000, 1000)]
    assert (bag.extent.start, bag.extent.end) == (START, START + 1999 * 1000)


async def test_a_part_of_a_bag_can_be_read(tmp_path: Path) -> None:
    scans = [(SCANS.name, b"\x00\x01\x00\x00", number * SECOND) for number in range(3)]
    bag = open_bag(await write(tmp_path / "bag", [*talk(20), *scans], CHATTER, SCANS))
    found = list(bag.messages({"/chatter"}, START + SECOND))
    assert [TYPES.decode(STRING, message.payload).data for message in found] == [str(n) for n in range(10, 20)]


async def test_single_files_and_folders_without_metadata_are_bags_too(tmp_path: Path) -> None:
    folder = await write(tmp_path / "bag", talk(3), CHATTER)
    assert open_bag(folder / "bag_0.mcap").topics == open_bag(folder).topics
    (folder / "metadata.yaml").unlink()
    assert open_bag(folder).extent.count == 3


@pytest.mark.parametrize(
    ("storage", "mode"),
    [
        (StoragePlugin.SQLITE3, CompressionMode.NONE),
        (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
        (StoragePlugin.MCAP, CompressionMode.NONE),
        (StoragePlugin.MCAP, CompressionMode.STORAGE),
        (StoragePlugin.MCAP, CompressionMode.FILE),
    ],
)
def test_bags_written_by_rosbags_are_read(tmp_path: Path, storage: StoragePlugin, mode: CompressionMode) -> None:
    bag = open_bag(by_rosbags(tmp_path / "bag", storage, mode))
    topic = bag.topics["/chatter"]
    assert (topic.type, topic.type_hash, topic.qos, topic.count) == (STRING, CHATTER.type_hash, (LATCHED,), 3)
    assert [(message.topic, message.payload, message.received - START) for message in bag.messages()] == talk(3)
    assert (bag.extent.start, bag.extent.end) == (START, START + SECOND // 5)


def test_a_sqlite_file_without_metadata_is_read(tmp_path: Path) -> None:
    folder = by_rosbags(tmp_path / "bag", StoragePlugin.SQLITE3)
    (file,) = folder.glob("*.db3")
    assert [message.payload for message in open_bag(file).messages()] == [payload for _, payload, _ in talk(3)]


async def test_files_of_a_split_bag_are_read_in_order(tmp_path: Path) -> None:
    names = [f"split_{number}.mcap" for number in range(11)]
    (tmp_path / "split").mkdir()
    for number, name in enumerate(names):
        part = await write(tmp_path / str(number), [(CHATTER.name, text(str(number)), number)], CHATTER)
        shutil.copy(part / f"{number}_0.mcap", tmp_path / "split" / name)
    bag = open_bag(tmp_path / "split")
    assert [message.received - START for message in bag.messages()] == list(range(11))
    assert bag.topics["/chatter"].count == 11


def test_a_file_without_chunks_is_read(tmp_path: Path) -> None:
    with (tmp_path / "fast.mcap").open("wb") as stream:
        writer = McapWriter(stream, use_chunking=False, compression=CompressionType.NONE)
        writer.start(profile="ros2")
        schema = writer.register_schema(STRING, "ros2msg", b"string data\n")
        channel = writer.register_channel("/chatter", "cdr", schema, {})
        for _, payload, time in talk(3):
            writer.add_message(channel, START + time, payload, START + time)
        writer.finish()
    assert [message.received - START for message in open_bag(tmp_path / "fast.mcap").messages()] == [
        time for _, _, time in talk(3)
    ]


async def test_an_unknown_topic_is_refused_with_similar_ones(tmp_path: Path) -> None:
    bag = open_bag(await write(tmp_path / "bag", talk(1), CHATTER, SCANS))
    assert bag.choose(()) == tuple(bag.topics.values())
    with pytest.raises(UnknownTopic, match="bag has no topic /chater") as raised:
        bag.choose(["/scan", "/chater"])
    assert raised.value.help == "did you mean `/chatter`?"
    with pytest.raises(UnknownTopic) as raised:
        bag.choose(["/odom"])
    assert raised.value.help == "topics: /chatter, /scan"


async def test_a_missing_bag_is_refused_with_similar_names(tmp_path: Path) -> None:
    await write(tmp_path / "drive_1", [])
    with pytest.raises(UnreadableBag, match=r"bag not found: .*drive_2") as raised:
        open_bag(tmp_path / "drive_2")
    assert raised.value.help == "did you mean `drive_1`?"


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.mcap", b"", "a.mcap is damaged, or not an MCAP file: invalid beginning of the file"),
        ("a.mcap", b"#!/bin/sh\n" * 10, "invalid beginning of the file"),
        ("a.db3", b"#!/bin/sh\n" * 10, "a.db3 is damaged, or not a bag"),
        ("a.bag", b"#ROSBAG V2.0\n", "a.bag is damaged, or not a bag: Unrecognized storage format"),
    ],
)
def test_files_that_are_not_bags_are_refused(tmp_path: Path, name: str, content: bytes, problem: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UnreadableBag, match=problem):
        open_bag(tmp_path / name)


def test_an_empty_folder_is_refused_as_a_bag(tmp_path: Path) -> None:
    with pytest.raises(UnreadableBag, match=r"expected metadata.yaml, or files .mcap or .db3"):
        open_bag(tmp_path)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("- 1", "missing `rosbag2_bagfile_information`"),
        ("rosbag2_bagfile_information: {version: [", "cannot read .*"),
        ("rosbag2_bagfile_information: {version: 9}", "storage_identifier: Field required"),
        (
            "rosbag2_bagfile_information: {version: 9, storage_identifier: mcap, relative_file_paths: [x.mcap]}",
            "cannot read .*x.mcap: No such file",
        ),
    ],
)
def test_invalid_metadata_is_refused(tmp_path: Path, content: str, problem: str) -> None:
    (tmp_path / "metadata.yaml").write_text(content)
    with pytest.raises(UnreadableBag, match=problem):
        open_bag(tmp_path)


async def test_damage_in_the_middle_of_a_bag_is_detected(tmp_path: Path) -> None:
    folder = await write(tmp_path / "bag", [(CHATTER.name, text("x" * 1000), n) for n in range(100)], CHATTER)
    file = folder / "bag_0.mcap"
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 0xFF
    file.write_bytes(content)
    with pytest.raises(UnreadableBag, match="is damaged"):
        list(open_bag(folder).messages())


def test_qos_of_old_bags_with_numbers_is_read(tmp_path: Path) -> None:
    folder = by_rosbags(tmp_path / "bag", StoragePlugin.SQLITE3)
    path = folder / "metadata.yaml"
    metadata = yaml.safe_load(path.read_text())
    numbers = (
        "- {history: 3, depth: 0, reliability: 2, durability: 2, deadline: {sec: 0, nsec: 0},"
        " lifespan: {sec: 2147483647, nsec: 4294967295}, liveliness: 1,"
        " liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}, avoid_ros_namespace_conventions: false}"
    )
    topic = metadata["rosbag2_bagfile_information"]["topics_with_message_count"][0]["topic_metadata"]
    topic["offered_qos_profiles"] = numbers
    metadata["rosbag2_bagfile_information"]["version"] = 5
    path.write_text(yaml.safe_dump(metadata))
    (qos,) = open_bag(folder).topics["/chatter"].qos
    assert not qos.is_reliable
    assert qos.durability is Durability.VOLATILE
    assert (qos.depth, qos.deadline, qos.lease) == (Qos().depth, None, None)


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd"])
async def test_damage_anywhere_is_reported_with_the_bag(tmp_path: Path, compression: Compression) -> None:
    folder = await write(tmp_path / "bag", talk(20), CHATTER, SCANS, compression=compression)
    file, random = folder / "bag_0.mcap", Random(1)
    content, reasons = file.read_bytes(), []
    for _ in range(25):
        damaged = bytearray(content)
        place = random.randrange(len(damaged))
        match random.randrange(3):
            case 0:
                damaged[place] = random.randrange(256)
            case 1:
                damaged[place : place + 8] = b"\xff" * 8
            case _:
                del damaged[place : place + random.randrange(1, 50)]
        file.write_bytes(damaged)
        for work in (open_bag, repair_bag):
            try:
                assert len(list(work(folder).messages())) <= 40
            except UnreadableBag as error:
                reasons.append(str(error))
    assert reasons
    assert all(str(folder) in reason for reason in reasons)
