"""Bags for tests."""

from collections.abc import Iterable
from pathlib import Path

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.recording.mcap_file import Compression
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bridges.ros2.recording.writer import MAX_WAITING, BagWriter, write_bag
from seoro.bridges.ros2.wire import Durability, Qos, Reliability

TYPES = TypeStore.bundled()
STRING = "std_msgs/msg/String"
SCAN = "sensor_msgs/msg/LaserScan"
SECOND = 1_000_000_000  # [ns]
START = 1_700_000_000 * SECOND

CHATTER = BagTopic("/chatter", STRING, TYPES.type_hash(STRING), (Qos(),))
LATCHED = Qos(Reliability.RELIABLE, Durability.TRANSIENT_LOCAL, depth=1)
SENSOR = Qos(Reliability.BEST_EFFORT, depth=5, deadline=200_000_000)
SCANS = BagTopic("/scan", SCAN, TYPES.type_hash(SCAN), (SENSOR, LATCHED))


def text(data: str) -> bytes:
    """Return the payload of a message of `/chatter`."""
    return TYPES.encode(STRING, {"data": data})


def add(writer: BagWriter, *topics: BagTopic) -> None:
    """Add topics with the definitions of their types."""
    for topic in topics:
        writer.add_topic(topic, TYPES.schema(topic.type))


async def write(
    folder: Path,
    messages: Iterable[tuple[str, bytes, int]],
    *topics: BagTopic,
    storage: str = "",
    compression: Compression = "none",
    most_waiting: int = MAX_WAITING,
) -> Path:
    """Write a bag of messages: (topic, payload, [ns] after `START`)."""
    async with write_bag(folder, storage=storage, compression=compression, most_waiting=most_waiting) as writer:
        add(writer, *topics)
        for topic, payload, time in messages:
            writer.write(topic, payload, START + time)
    return folder


def talk(count: int, period: int = SECOND // 10) -> list[tuple[str, bytes, int]]:
    """Return messages of `/chatter`: `0`, `1`, ..."""
    return [(CHATTER.name, text(str(number)), number * period) for number in range(count)]
