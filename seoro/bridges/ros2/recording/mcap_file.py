"""One MCAP file, written as rosbag2 writes it (profile `ros2`).

What has been flushed is in whole chunks, so that it can be read whatever becomes of the process afterwards.
"""

from __future__ import annotations

import contextlib
import fcntl
from collections.abc import Mapping
from dataclasses import replace
from io import BufferedWriter, FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from seoro import __version__
from seoro.bridges.ros2.recording.metadata import BagTopic, Extent, dump, information
from seoro.bridges.ros2.recording.profiles import profile

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

CHUNK: Final = 1024 * 1024  # [bytes] after which a chunk is written

Compression = Literal["none", "lz4", "zstd"]

_COMPRESSIONS: Final = {
    "none": CompressionType.NONE,
    "lz4": CompressionType.LZ4,
    "zstd": CompressionType.ZSTD,
}
_PART: Final = 512 * 1024  # [bytes]
_SEQUENCE: Final = 0xFFFF_FFFF  # MCAP has 32 bits for the number of a message


class _Stream(BufferedWriter):
    """A file into which much is written in parts: a single write of 10 MB keeps some kernels busy for 50 ms."""

    def write(self, content: ReadableBuffer) -> int:
        """Write everything."""
        view = memoryview(content)
        for start in range(0, len(view), _PART):
            super().write(view[start : start + _PART])
        return len(view)


class McapFile:
    """A new file. Its methods raise `OSError` when the disk does not take what is written.

    Args:
        path: Where to; nothing may be there.
        compression: Of the chunks.
    """

    def __init__(self, path: Path, compression: Compression) -> None:
        self._path = path
        self._stream = _Stream(FileIO(path, "xb"), CHUNK)
        with contextlib.suppress(OSError):  # not all file systems have locks
            fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)  # nobody mends what is being written
        self._writer = Writer(self._stream, chunk_size=CHUNK, compression=_COMPRESSIONS[compression])
        self._writer.start(profile=Profile.ROS2, library=f"seoro-{__version__}")
        self._stream.flush()  # an empty file could not be read, if it came to that
        self._schemas: dict[str, int] = {}
        self._topics: dict[int, BagTopic] = {}
        self._counts: dict[int, int] = {}
        self._extent = Extent()

    def information(self, notes: Mapping[str, str]) -> dict[str, Any]:
        """What `metadata.yaml` says of the file so far.

        Args:
            notes: What else there is to say.
        """
        topics = [replace(topic, count=self._counts[channel]) for channel, topic in self._topics.items()]
        return information({self._path.name: self._extent}, topics, notes)

    def add_topic(self, topic: BagTopic, definition: str) -> int:
        """Add a topic, before its first message.

        Args:
            topic: What to say of it.
            definition: Of its type with all that it refers to (`TypeStore.schema`); empty where it is not known.

        Returns:
            By what messages refer to it.
        """
        schema = self._schemas.get(topic.type)
        if schema is None:
            encoding = SchemaEncoding.ROS2 if definition else SchemaEncoding.SelfDescribing
            schema = self._writer.register_schema(topic.type, encoding, definition.encode())
            self._schemas[topic.type] = schema
        about = {
            "offered_qos_profiles": dump([profile(qos) for qos in topic.qos]) if topic.qos else "",
            "topic_type_hash": topic.type_hash,
        }
        channel = self._writer.register_channel(topic.name, MessageEncoding.CDR, schema, about)
        self._topics[channel] = topic
        self._counts[channel] = 0
        return channel

    def add_message(self, channel: int, payload: bytes, received: int, sent: int, sequence: int) -> None:
        """Add a message of a topic.

        Args:
            channel: The topic.
            payload: CDR, with its header.
            received, sent: [ns] since the epoch.
            sequence: Its number among those of its sender.
        """
        self._extent = self._extent | Extent(received, received, 1)
        self._counts[channel] += 1
        self._writer.add_message(channel, received, payload, sent, sequence & _SEQUENCE)

    def flush(self) -> None:
        """Give all that has been added to the operating system."""
        self._writer.flush()

    def finish(self, notes: Mapping[str, str]) -> None:
        """Make the file whole: with its index, and what `metadata.yaml` says in a record."""
        self._writer.flush()
        self._writer.add_metadata("rosbag2", {"serialized_metadata": dump(self.information(notes))})
        self._writer.finish()
        self._stream.close()

    def abandon(self) -> None:
        """Close the file as it is, after an error."""
        with contextlib.suppress(OSError):  # what is in its buffer cannot be written either
            self._stream.close()
