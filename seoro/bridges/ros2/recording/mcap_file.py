"""Writer of an MCAP file in the format of rosbag2 (profile `ros2`).

Flushed messages are in complete chunks, so that they can be read if the process is killed.
"""

from __future__ import annotations

import contextlib
import fcntl
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from io import BufferedWriter, FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from seoro import __version__
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic, Extent, dump, information
from seoro.bridges.ros2.recording.profiles import profile

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

CHUNK: Final = 1024 * 1024  # [bytes] of a chunk

Compression = Literal["none", "lz4", "zstd"]

_PART: Final = 512 * 1024  # [bytes] of a single write
_SEQUENCE: Final = 0xFFFF_FFFF  # sequence numbers of MCAP have 32 bits


class _Stream(BufferedWriter):
    """A file that splits large writes: a single write of 10 MB blocks some kernels for 50 ms."""

    def write(self, content: ReadableBuffer) -> int:
        """Write all bytes."""
        view = memoryview(content)
        for start in range(0, len(view), _PART):
            super().write(view[start : start + _PART])
        return len(view)


class McapFile:
    """A new MCAP file. Methods raise `OSError` if a write fails.

    Args:
        path: Path of the file, which must not exist.
        compression: Compression of the chunks.
    """

    def __init__(self, path: Path, compression: Compression) -> None:
        self._path = path
        self._stream = _Stream(FileIO(path, "xb"), CHUNK)
        with contextlib.suppress(OSError):  # some file systems have no locks
            fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)  # prevents a repair meanwhile
        self._writer = Writer(self._stream, chunk_size=CHUNK, compression=CompressionType[compression.upper()])
        self._writer.start(profile=Profile.ROS2, library=f"seoro-{__version__}")
        self._stream.flush()  # makes the file readable
        self._schemas: dict[str, int] = {}
        self._topics: list[BagTopic] = []
        self._channels: dict[str, int] = {}
        self._counts: Counter[str] = Counter()
        self._extent = Extent()

    def information(self, notes: Mapping[str, str]) -> dict[str, Any]:
        """Return the entry of `metadata.yaml` for the file so far.

        Args:
            notes: Further notes.
        """
        topics = [replace(topic, count=self._counts[topic.name]) for topic in self._topics]
        return information({self._path.name: self._extent}, topics, notes)

    def add_topic(self, topic: BagTopic, definition: str) -> None:
        """Add a topic, before its first message.

        Args:
            topic: Description of the topic.
            definition: Definition of its type (`TypeStore.schema`); empty if it is unknown.
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
        self._channels[topic.name] = self._writer.register_channel(topic.name, MessageEncoding.CDR, schema, about)
        self._topics.append(topic)

    def add_message(self, message: BagMessage) -> None:
        """Add a message of a topic."""
        received, sequence = message.received, message.sequence & _SEQUENCE
        self._extent = self._extent | Extent(received, received, 1)
        self._counts[message.topic] += 1
        self._writer.add_message(self._channels[message.topic], received, message.payload, message.sent, sequence)

    def flush(self) -> None:
        """Pass all added messages to the operating system."""
        self._writer.flush()

    def finish(self, notes: Mapping[str, str]) -> None:
        """Complete the file with its index, and with a record of the content of `metadata.yaml`."""
        self._writer.flush()
        self._writer.add_metadata("rosbag2", {"serialized_metadata": dump(self.information(notes))})
        self._writer.finish()
        self._stream.close()

    def abandon(self) -> None:
        """Close the incomplete file after an error."""
        with contextlib.suppress(OSError):  # the buffer cannot be written, either
            self._stream.close()
