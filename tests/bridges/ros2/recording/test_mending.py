import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bridges.ros2.recording.reader import open_bag, repair_bag
from seoro.bridges.ros2.recording.scanning import scan
from seoro.bridges.ros2.recording.writer import write_bag
from tests.bridges.ros2.recording.bags import CHATTER, START, add, text, write


async def whole(folder: Path) -> Path:
    """Write a bag of several chunks."""
    messages = [(CHATTER.name, text(f"{number} " + "x" * 100_000), number) for number in range(50)]
    return await write(folder, messages, CHATTER)


async def test_a_truncated_bag_is_read_and_repaired_up_to_its_end(tmp_path: Path) -> None:
    file = await whole(tmp_path / "bag") / "bag_0.mcap"
    content = file.read_bytes()
    counts = []
    for share in (0.001, 0.3, 0.5, 0.9, 0.99):
        file.write_bytes(content[: int(len(content) * share)])
        bag = open_bag(tmp_path / "bag")
        assert bag.is_cut_off
        times = [message.received - START for message in bag.messages()]
        assert times == list(range(len(times)))
        mended = repair_bag(tmp_path / "bag")
        assert (mended.is_cut_off, mended.extent.count) == (False, len(times))
        with Reader(tmp_path / "bag") as reader:
            assert sum(1 for _ in reader.messages()) == len(times)
        counts.append(len(times))
    assert counts[0] == 0
    assert counts == sorted(counts)
    assert counts[-1] > 40


async def test_a_bag_truncated_between_a_chunk_and_its_index_loses_no_message(tmp_path: Path) -> None:
    messages = [(name, text("x" * 100_000), number) for number in range(15) for name in (CHATTER.name, "/other")]
    other = BagTopic("/other", CHATTER.type, CHATTER.type_hash, CHATTER.qos)
    file = await write(tmp_path / "bag", messages, CHATTER, other) / "bag_0.mcap"
    content = file.read_bytes()
    with file.open("rb") as stream:
        chunks = scan(stream).summary.chunk_indexes
    last = chunks[-1].chunk_start_offset + chunks[-1].chunk_length
    assert chunks[-1].message_index_length > 50
    for beyond in range(0, chunks[-1].message_index_length + 1, 37):
        file.write_bytes(content[: last + beyond])
        repair_bag(tmp_path / "bag")
        with Reader(tmp_path / "bag") as reader:
            found = [(each.topic, time - START, bytes(payload)) for each, time, payload in reader.messages()]
        assert sorted(found) == sorted((name, time, payload) for name, payload, time in messages)
        with file.open("rb") as stream:
            assert len(list(make_reader(stream, validate_crcs=True).iter_messages())) == len(messages)


async def test_metadata_of_a_repaired_bag_describes_its_content(tmp_path: Path) -> None:
    folder = await whole(tmp_path / "bag")
    file = folder / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[:3_000_000])
    (folder / "metadata.yaml").unlink()
    repair_bag(folder)
    metadata = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    (topic,) = metadata["topics_with_message_count"]
    assert topic["message_count"] == metadata["message_count"] == open_bag(folder).extent.count > 0
    assert topic["topic_metadata"]["type_description_hash"] == CHATTER.type_hash


async def test_repairing_an_intact_bag_changes_nothing(tmp_path: Path) -> None:
    folder = await whole(tmp_path / "bag")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    repair_bag(folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


async def test_a_bag_damaged_in_the_middle_is_not_truncated(tmp_path: Path) -> None:
    file = await whole(tmp_path / "bag") / "bag_0.mcap"
    content = bytearray(file.read_bytes()[:-10])
    content[len(content) // 2] ^= 0xFF
    file.write_bytes(content)
    with pytest.raises(UnreadableBag, match=r"damaged record at byte [\d,]+"):
        repair_bag(tmp_path / "bag")
    assert file.read_bytes() == content


async def test_zeros_at_the_end_of_a_bag_are_removed(tmp_path: Path) -> None:
    file = await whole(tmp_path / "bag") / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[:3_000_000] + bytes(5000))
    assert repair_bag(tmp_path / "bag").extent.count > 15
    with Reader(tmp_path / "bag") as reader:
        assert sum(1 for _ in reader.messages()) == reader.message_count


async def test_a_bag_that_is_being_written_is_not_repaired(tmp_path: Path) -> None:
    async with write_bag(tmp_path / "bag") as writer:
        add(writer, CHATTER)
        writer.write(CHATTER.name, text("one"), START)
        with pytest.raises(UnreadableBag, match=r"bag_0\.mcap is still being written"):
            repair_bag(tmp_path / "bag")
    assert open_bag(tmp_path / "bag").extent.count == 1


async def test_a_bag_file_without_a_folder_is_repaired(tmp_path: Path) -> None:
    file = (await whole(tmp_path / "bag") / "bag_0.mcap").rename(tmp_path / "alone.mcap")
    file.write_bytes(file.read_bytes()[:-100])
    assert repair_bag(file).extent.count == 50
    assert not (tmp_path / "metadata.yaml").exists()


async def test_an_unfinished_write_of_sqlite_is_undone(tmp_path: Path) -> None:
    bag, killed = tmp_path / "bag", tmp_path / "killed"
    messages = [(CHATTER.name, text(f"{number} " + "x" * 10_000), number) for number in range(50)]
    await write(bag, messages, CHATTER, storage="sqlite3")
    with closing(sqlite3.connect(bag / "bag_0.db3")) as database:
        database.execute("PRAGMA cache_size = 1")  # so that uncommitted pages are in the file
        database.execute("INSERT INTO messages SELECT id + 50, topic_id, timestamp + 50, data FROM messages")
        shutil.copytree(bag, killed)
        with pytest.raises(UnreadableBag, match="still being written"):
            repair_bag(bag)
    for path in (killed, killed / "bag_0.db3"):
        with pytest.raises(UnreadableBag, match="unfinished write") as found:
            open_bag(path)
        assert f"seoro bag {killed} --repair" in found.value.help
    assert repair_bag(killed).extent.count == 50
    with Reader(killed) as reader:
        assert [time - START for _, time, _ in reader.messages()] == list(range(50))


def test_files_that_are_not_bags_are_not_repaired(tmp_path: Path) -> None:
    with pytest.raises(UnreadableBag, match="not a bag of MCAP or SQLite files"):
        repair_bag(tmp_path)
    (tmp_path / "a.db3").write_text("my notes" * 100)
    with pytest.raises(UnreadableBag, match="not an SQLite file"):
        repair_bag(tmp_path)
    (tmp_path / "a.mcap").write_text("my notes")
    with pytest.raises(UnreadableBag, match="not an MCAP file"):
        repair_bag(tmp_path)
    assert (tmp_path / "a.mcap").read_text() == "my notes"
