import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import anyio
import pytest
import yaml
from mcap.reader import DecodedMessageTuple, make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

from seoro.bridges.ros2.recording import writer as writer_module
from seoro.bridges.ros2.recording.errors import RefusedRecording
from seoro.bridges.ros2.recording.mcap_file import CHUNK, Compression
from seoro.bridges.ros2.recording.metadata import BagTopic, read_metadata
from seoro.bridges.ros2.recording.reader import Bag, open_bag, repair_bag
from seoro.bridges.ros2.recording.writer import write_bag
from tests.bridges.ros2.recording.bags import (
    CHATTER,
    SCAN,
    SCANS,
    SECOND,
    START,
    STRING,
    TYPES,
    add,
    talk,
    text,
    write,
)
from tests.bridges.ros2.recording.talker import SIZE


def decoded(file: Path) -> list[DecodedMessageTuple]:
    """Return the messages that mcap-ros2-support reads from a file."""
    with file.open("rb") as stream:
        return list(make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages())


def talker(bag: Path, limit: int = 0, storage: str = "mcap") -> subprocess.Popen[str]:
    """Start a process that writes a bag endlessly."""
    command = [sys.executable, "-m", "tests.bridges.ros2.recording.talker", str(bag), str(limit), storage]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def kill_a_talker(bag: Path, file: Path, storage: str) -> None:
    """Write a bag in a process until its file has some chunks, and kill the process."""
    process = talker(bag, storage=storage)
    assert process.stdout is not None
    while process.stdout.readline() and file.stat().st_size < 5 * CHUNK:
        pass
    process.send_signal(signal.SIGKILL)
    process.communicate()


def check_numbers(bag: Bag, file: Path) -> int:
    """Check that a bag has all messages of a killed process but the last ones, and return their number."""
    numbers = [int(TYPES.decode(STRING, message.payload).data.split()[0]) for message in bag.messages()]
    assert numbers == list(range(len(numbers)))
    assert len(numbers) * SIZE > file.stat().st_size - 2 * CHUNK
    return len(numbers)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
async def test_rosbags_reads_written_bags_with_types_hashes_and_qos(storage: str, tmp_path: Path) -> None:
    scan = TYPES.encode(SCAN, {"angle_max": 1.0, "ranges": [1.0, 2.5]})
    bag = await write(tmp_path / "bag", [*talk(3), (SCANS.name, scan, 50)], CHATTER, SCANS, storage=storage)
    with Reader(bag) as reader:
        assert {each.topic: (each.msgtype, each.digest, each.msgcount) for each in reader.connections} == {
            "/chatter": (STRING, CHATTER.type_hash, 3),
            "/scan": (SCAN, SCANS.type_hash, 1),
        }
        offered = {each.topic: each.ext.offered_qos_profiles for each in reader.connections}  # type: ignore[union-attr]
        assert [(each.reliability.name, each.durability.name, each.depth) for each in offered["/scan"]] == [
            ("BEST_EFFORT", "VOLATILE", 5),
            ("RELIABLE", "TRANSIENT_LOCAL", 1),
        ]
        assert (offered["/scan"][0].deadline.sec, offered["/scan"][0].deadline.nsec) == (0, 200_000_000)
        assert reader.start_time == START
        assert reader.duration == SECOND // 5 + 1  # rosbags ends after the last message
        found = [(each.topic, bytes(payload), time - START) for each, time, payload in reader.messages()]
    assert found == [talk(1)[0], (SCANS.name, scan, 50), *talk(3)[1:]]


async def test_sqlite_bags_are_read_with_definitions_and_notes(tmp_path: Path) -> None:
    async with write_bag(tmp_path / "bag", storage="sqlite3") as writer:
        add(writer, CHATTER, SCANS)
        writer.note("notes", "dark")
        for topic, payload, time in talk(3):
            writer.write(topic, payload, START + time)
    bag = open_bag(tmp_path / "bag")
    assert [bytes(each.payload) for each in bag.messages()] == [text(str(number)) for number in range(3)]
    assert (bag.topics["/scan"].qos, bag.notes["notes"]) == (SCANS.qos, "dark")
    with closing(sqlite3.connect(tmp_path / "bag" / "bag_0.db3")) as file:
        found = dict(file.execute("SELECT topic_type, encoded_message_definition FROM message_definitions"))
        [(version, metadata)] = file.execute("SELECT metadata_version, metadata FROM metadata")
    assert found == {STRING: TYPES.schema(STRING), SCAN: TYPES.schema(SCAN)}
    assert (version, yaml.safe_load(metadata)["storage_identifier"]) == (9, "sqlite3")


async def test_unsupported_storages_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RefusedRecording, match="unsupported storage `csv`: expected `mcap` or `sqlite3`"):
        async with write_bag(tmp_path / "bag", storage="csv"):
            pass
    with pytest.raises(RefusedRecording, match="unsupported compression of `sqlite3`"):
        async with write_bag(tmp_path / "bag", storage="sqlite3", compression="zstd"):
            pass
    assert not (tmp_path / "bag").exists()


async def test_mcap_ros2_support_decodes_by_the_definitions_in_the_file(tmp_path: Path) -> None:
    scan = TYPES.encode(SCAN, {"header": {"frame_id": "lidar"}, "ranges": [1.0, 2.5]})
    bag = await write(tmp_path / "bag", [(SCANS.name, scan, 0), *talk(2)], CHATTER, SCANS)
    read = decoded(bag / "bag_0.mcap")
    assert [each.decoded_message.data for each in read if each.channel.topic == "/chatter"] == ["0", "1"]
    (found,) = [each.decoded_message for each in read if each.channel.topic == "/scan"]
    assert (found.header.frame_id, list(found.ranges)) == ("lidar", [1.0, 2.5])


@pytest.mark.parametrize("compression", ["lz4", "zstd"])
async def test_compressed_bags_are_smaller_and_readable(tmp_path: Path, compression: Compression) -> None:
    messages = [(CHATTER.name, text("the same " * 100), number) for number in range(1000)]
    bag = await write(tmp_path / "bag", messages, CHATTER, compression=compression)
    assert (bag / "bag_0.mcap").stat().st_size < 200_000
    assert open_bag(bag).extent.count == 1000
    with Reader(bag) as reader:
        assert sum(1 for _ in reader.messages()) == 1000


async def test_messages_beyond_the_queue_are_dropped_counted_and_noted(tmp_path: Path) -> None:
    large = text("x" * 1000)
    async with write_bag(tmp_path / "bag", most_waiting=2500) as writer:
        add(writer, CHATTER)
        taken = [writer.write(CHATTER.name, large, START) for _ in range(5)]
        assert taken == [True, True, False, False, False]
        assert writer.lost == {"/chatter": 3}
    metadata = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert metadata["custom_data"] == {"lost": "3 of /chatter"}
    assert open_bag(tmp_path / "bag").extent.count == 2


async def test_a_bag_without_messages_can_be_read(tmp_path: Path) -> None:
    bag = await write(tmp_path / "bag", [], CHATTER)
    assert (open_bag(bag).extent.count, list(open_bag(bag).topics)) == (0, ["/chatter"])
    with Reader(bag) as reader:
        assert list(reader.messages()) == []


async def test_undefined_types_are_recorded_without_definition(tmp_path: Path) -> None:
    async with write_bag(tmp_path / "bag") as writer:
        writer.add_topic(BagTopic("/own", "my_msgs/msg/Own", "RIHS01_" + "0" * 64), "")
        writer.write("/own", b"\x00\x01\x00\x00\x07", START)
    assert open_bag(tmp_path / "bag").topics["/own"].type == "my_msgs/msg/Own"
    with Reader(tmp_path / "bag") as reader:
        assert [bytes(payload) for _, _, payload in reader.messages()] == [b"\x00\x01\x00\x00\x07"]


async def test_an_existing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RefusedRecording, match="exists; expected a new folder"):
        async with write_bag(tmp_path):
            pass


async def test_a_folder_that_cannot_be_created_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RefusedRecording, match=r"cannot create .*: Not a directory"):
        async with write_bag(tmp_path / "file" / "bag"):
            pass


async def test_the_bag_is_intact_when_the_block_raises(tmp_path: Path) -> None:
    with pytest.raises(KeyError):
        async with write_bag(tmp_path / "bag") as writer:
            add(writer, CHATTER)
            writer.write(CHATTER.name, text("last"), START)
            raise KeyError
    assert not open_bag(tmp_path / "bag").is_cut_off
    assert open_bag(tmp_path / "bag").extent.count == 1


async def test_messages_are_flushed_to_the_file_periodically(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer_module, "PERIOD", 0.02)
    async with write_bag(tmp_path / "bag") as writer:
        add(writer, CHATTER)
        writer.write(CHATTER.name, text("now"), START)
        with anyio.fail_after(30.0):
            while not open_bag(tmp_path / "bag").extent.count:
                await anyio.sleep(0.01)
        assert [message.topic for message in open_bag(tmp_path / "bag").messages()] == [CHATTER.name]


def test_a_killed_process_leaves_a_bag_with_all_complete_chunks(tmp_path: Path) -> None:
    bag, file = tmp_path / "bag", tmp_path / "bag" / "bag_0.mcap"
    kill_a_talker(bag, file, "mcap")
    found = open_bag(bag)
    assert list(read_metadata(bag).topics()) == [CHATTER.name]  # type: ignore[union-attr]
    assert found.is_cut_off
    count = check_numbers(found, file)
    assert repair_bag(bag).extent.count == count
    with Reader(bag) as reader:
        assert reader.message_count == sum(1 for _ in reader.messages()) == count
        assert [each.digest for each in reader.connections] == [CHATTER.type_hash]
    assert len(decoded(file)) == count


def test_a_killed_process_leaves_a_bag_of_sqlite_with_all_flushed_messages(tmp_path: Path) -> None:
    bag, file = tmp_path / "bag", tmp_path / "bag" / "bag_0.db3"
    kill_a_talker(bag, file, "sqlite3")
    count = check_numbers(repair_bag(bag), file)
    with Reader(bag) as reader:
        assert reader.message_count == sum(1 for _ in reader.messages()) == count


@pytest.mark.parametrize(
    ("storage", "reason"),
    [
        ("mcap", "bag_0.mcap any more: File too large"),
        ("sqlite3", "bag_0.db3 any more: OperationalError: disk I/O error"),
    ],
)
def test_a_full_disk_is_an_error_and_leaves_a_readable_bag(storage: str, reason: str, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    process = talker(bag, 3 * CHUNK, storage)
    _, errors = process.communicate(timeout=60)
    last = errors.splitlines()[-1]
    assert last.endswith(reason)
    found = open_bag(bag)
    assert found.extent.count * SIZE > 1.5 * CHUNK
    assert sum(1 for _ in found.messages()) == found.extent.count
