"""Index and repair of truncated MCAP files, whose writer was killed or had no disk space.

The index of such a file is missing, and its last record may be incomplete. Complete chunks are valid: they have a
checksum. The index is made again from these chunks, which is enough to read the file (`scan`). `repair` appends
the index, so that other tools can read the file, too.
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

MAX_RECORD: Final = 1 << 30  # [bytes]

# Exceptions when a damaged file, or a file in another format, is read.
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
class _Record:
    kind: int
    start: int  # [bytes] from the beginning of the file or chunk
    end: int
    content: bytes

    def stream(self) -> ReadDataStream:
        """Return a stream of the content."""
        return ReadDataStream(BytesIO(self.content))


@dataclass
class Scan:
    """Complete chunks of a file, from its records.

    Attributes:
        summary: Index of the chunks.
        end: End of the last complete chunk, or of its message indexes if these are complete [bytes].
        unindexed: Message indexes of the last chunk if they are missing in the file.
    """

    summary: Summary = field(default_factory=Summary)
    end: int = len(MCAP0_MAGIC)
    unindexed: tuple[MessageIndex, ...] = ()
    counts: Counter[int] = field(default_factory=Counter)  # by channel
    earliest: int = (1 << 64) - 1  # [ns]
    latest: int = 0  # [ns]
    chunk_end: int = 0
    chunk_messages: dict[int, MessageIndex] = field(default_factory=dict)  # of the last chunk, by channel

    def note(self, record: _Record) -> bool:
        """Add a record of the file; return False if the rest of the file is unusable."""
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
            case Opcode.DATA_END | 0:  # some file systems append zeros after a power failure
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

    def finish(self) -> None:
        """Complete the index after all records."""
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
            self.end, self.unindexed = self.chunk_end, tuple(self.chunk_messages.values())


def scan(stream: IO[bytes]) -> Scan:
    """Find all complete chunks of a file.

    Raises:
        McapError: The file is not an MCAP file, is damaged before its end, or has a record that is too large.
    """
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise McapError("invalid beginning of the file")
    found = Scan()
    for record in _records(stream, len(MCAP0_MAGIC), size):
        try:
            if not found.note(record):
                break
        except DAMAGES as error:
            if record.end < size:
                raise McapError(f"damaged record at byte {record.start:,}: {error}") from None
            break
    found.finish()
    return found


def repair(path: Path) -> None:
    """Repair a truncated file: remove the incomplete chunk, and append an index.

    Raises:
        McapError: The file is not an MCAP file, or is damaged before its end.
        BlockingIOError: The file is still being written.
        OSError: The file cannot be read or written.
    """
    with path.open("r+b") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        found = scan(stream)
        stream.truncate(found.end)
        stream.seek(found.end)
        stream.write(_ending(found))


def is_whole(stream: IO[bytes]) -> bool:
    """Return whether a file has the end of an MCAP file."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(max(0, size - len(MCAP0_MAGIC)))
    return size > 2 * len(MCAP0_MAGIC) and stream.read() == MCAP0_MAGIC


def _records(stream: IO[bytes], start: int, size: int) -> Iterator[_Record]:
    """Yield the complete records from the position of a stream.

    Args:
        stream: Stream of the records.
        start: Position of the stream.
        size: End of the records.
    """
    while len(head := stream.read(_HEAD.size)) == _HEAD.size:
        kind, length = _HEAD.unpack(head)
        end = start + _HEAD.size + length
        if end > size:
            return
        if length > MAX_RECORD:
            raise McapError(f"record of {length:,} bytes exceeds the limit of {MAX_RECORD:,}")
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
    """Return the records after the last chunk of a complete file."""
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
