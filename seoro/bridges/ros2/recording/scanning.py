"""Reading and mending MCAP files that end in the middle, since whoever wrote them was killed or had no room left.

The index of such a file is missing, and its last record may be a part of one. Whole chunks are sound: they have a
checksum. From these the index is made again, which is enough to read the file (`scan`), or is put at its end, so
that others can read it too (`mend`).
"""

from __future__ import annotations

import fcntl
import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, Final

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, MessageIndex, Schema, Statistics
from mcap.stream_reader import get_chunk_data_stream
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

MOST_RECORD: Final = 1 << 30  # [bytes]

# What reading a file may raise that is no MCAP file, or a damaged one.
DAMAGES: Final = (
    McapError,
    ValueError,
    LookupError,
    EOFError,
    OverflowError,
    MemoryError,
    RuntimeError,
    struct.error,
    zlib.error,
    ZstdError,
)

_HEAD: Final = struct.Struct("<BQ")  # kind and length of a record
_MESSAGE: Final = struct.Struct("<HIQ")  # channel, number and time of a message


@dataclass(frozen=True)
class Scan:
    """What whole chunks there are in a file.

    Attributes:
        summary: Its index.
        end: [bytes] where the last whole chunk ends, with its index of messages if that is whole.
        unindexed: The index of messages of the last chunk if that is missing there.
    """

    summary: Summary
    end: int
    unindexed: tuple[MessageIndex, ...]


@dataclass(frozen=True)
class _Record:
    kind: int
    start: int  # [bytes] from the beginning of the file, or of what is in the chunk
    end: int
    content: bytes

    def stream(self) -> ReadDataStream:
        """To read its content from."""
        return ReadDataStream(BytesIO(self.content))


@dataclass
class _Scanner:
    """Takes note of one record after the other."""

    summary: Summary = field(default_factory=Summary)
    end: int = len(MCAP0_MAGIC)
    counts: Counter[int] = field(default_factory=Counter)  # by channel
    earliest: int = (1 << 64) - 1  # [ns]
    latest: int = 0  # [ns]
    chunk_end: int = 0
    chunk_messages: dict[int, MessageIndex] = field(default_factory=dict)  # of the last chunk, by channel

    def note(self, record: _Record) -> bool:
        """Take note of a record of the file; False if what comes from there on is of no use."""
        match record.kind:
            case Opcode.CHUNK:
                chunk = Chunk.read(record.stream())
                inside, length = get_chunk_data_stream(chunk, validate_crc=True)
                self.chunk_messages = {}
                for each in _records(BytesIO(inside.read(length)), 0, length):
                    self._note_inside(each)
                self.summary.chunk_indexes.append(_chunk_index(chunk, record))
                self.chunk_end = record.end
            case Opcode.MESSAGE_INDEX if self.summary.chunk_indexes:
                index, chunk_index = MessageIndex.read(record.stream()), self.summary.chunk_indexes[-1]
                chunk_index.message_index_offsets[index.channel_id] = record.start
                chunk_index.message_index_length += record.end - record.start
            case Opcode.DATA_END | 0:  # zeros are what some file systems leave when power fails
                return False
            case _:
                self._note_inside(record)
        self.end = record.end
        return True

    def _note_inside(self, record: _Record) -> None:
        match record.kind:
            case Opcode.SCHEMA:
                schema = Schema.read(record.stream())
                self.summary.schemas[schema.id] = schema
            case Opcode.CHANNEL:
                channel = Channel.read(record.stream())
                self.summary.channels[channel.id] = channel
            case Opcode.MESSAGE:
                channel_id, _, time = _MESSAGE.unpack_from(record.content)
                self.counts[channel_id] += 1
                self.earliest = min(self.earliest, time)
                self.latest = max(self.latest, time)
                index = self.chunk_messages.setdefault(channel_id, MessageIndex(channel_id, []))
                index.records.append((time, record.start))

    def result(self) -> Scan:
        """What was found."""
        summary = self.summary
        summary.statistics = Statistics(
            attachment_count=0,
            channel_count=len(summary.channels),
            channel_message_counts=dict(self.counts),
            chunk_count=len(summary.chunk_indexes),
            message_count=self.counts.total(),
            message_end_time=self.latest,
            message_start_time=self.earliest if self.counts else 0,
            metadata_count=0,
            schema_count=len(summary.schemas),
        )
        if (
            summary.chunk_indexes
            and summary.chunk_indexes[-1].message_index_offsets.keys() < self.chunk_messages.keys()
        ):
            summary.chunk_indexes[-1].message_index_offsets.clear()
            summary.chunk_indexes[-1].message_index_length = 0
            return Scan(summary, self.chunk_end, tuple(self.chunk_messages.values()))
        return Scan(summary, self.end, ())


def scan(stream: IO[bytes]) -> Scan:
    """Find all whole chunks of a file.

    Raises:
        McapError: It is no MCAP file, is damaged before its end, or has a record that is too large.
    """
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise McapError("it does not begin as MCAP files do")
    scanner = _Scanner()
    for record in _records(stream, len(MCAP0_MAGIC), size):
        try:
            if not scanner.note(record):
                break
        except DAMAGES as error:
            if record.end < size:
                raise McapError(f"what is at byte {record.start:,} is damaged: {error}") from None
            break
    return scanner.result()


def mend(path: Path) -> None:
    """Make a file whole that ends in the middle: cut off what is no whole chunk, and put its index at the end.

    Raises:
        McapError: It is no MCAP file, or is damaged before its end.
        BlockingIOError: It is still being written.
        OSError: It cannot be read or written.
    """
    with path.open("r+b") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        found = scan(stream)
        stream.truncate(found.end)
        stream.seek(found.end)
        stream.write(_ending(found))


def is_whole(stream: IO[bytes]) -> bool:
    """Whether a file ends as MCAP files do."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(max(0, size - len(MCAP0_MAGIC)))
    return size > 2 * len(MCAP0_MAGIC) and stream.read() == MCAP0_MAGIC


def _records(stream: IO[bytes], start: int, size: int) -> Iterator[_Record]:
    """The records from where a stream stands that are there as a whole.

    Args:
        stream: Where they are.
        start: Where it stands.
        size: Where it ends.
    """
    while len(head := stream.read(_HEAD.size)) == _HEAD.size:
        kind, length = _HEAD.unpack(head)
        end = start + _HEAD.size + length
        if end > size:
            return
        if length > MOST_RECORD:
            raise McapError(f"it has a record of {length:,} bytes; {MOST_RECORD:,} are read at most")
        yield _Record(kind, start, end, stream.read(length))
        start = end


def _chunk_index(chunk: Chunk, record: _Record) -> ChunkIndex:
    return ChunkIndex(
        chunk_length=record.end - record.start,
        chunk_start_offset=record.start,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=chunk.message_end_time,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=chunk.message_start_time,
        uncompressed_size=chunk.uncompressed_size,
    )


def _ending(found: Scan) -> bytes:
    """What stands after the last chunk of a whole file."""
    builder, summary = RecordBuilder(), found.summary
    for index in found.unindexed:
        chunk = summary.chunk_indexes[-1]
        chunk.message_index_offsets[index.channel_id] = found.end + builder.count
        index.write(builder)
        chunk.message_index_length = builder.count
    DataEnd(0).write(builder)
    summary_start = found.end + builder.count
    assert summary.statistics is not None
    for record in (
        *summary.schemas.values(),
        *summary.channels.values(),
        summary.statistics,
        *summary.chunk_indexes,
    ):
        record.write(builder)
    Footer(summary_start=summary_start, summary_offset_start=0, summary_crc=0).write(builder)
    return bytes(builder.end()) + MCAP0_MAGIC
