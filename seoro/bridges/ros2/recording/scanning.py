"""Reading and mending MCAP files that end in the middle, since whoever wrote them was killed or had no room left.

The index of such a file is missing, and its last record may be a part of one. Whole chunks are sound: they have a
checksum. From these the index is made again, which is enough to read the file (`scan`), or is put at its end, so
that others can read it too (`mend`).
"""

from __future__ import annotations

import os
import struct
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, Final

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    Message,
    MessageIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import CRCValidationError, breakup_chunk
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC

MOST_RECORD: Final = 1 << 30  # [bytes]

_HEAD: Final = struct.Struct("<BQ")  # kind and length of a record


@dataclass(frozen=True)
class Scan:
    """What whole chunks there are in a file.

    Attributes:
        summary: Its index.
        end: [bytes] from the beginning, where the last whole chunk and its index of messages end.
        size: [bytes] of the whole file.
    """

    summary: Summary
    end: int
    size: int


@dataclass(frozen=True)
class _Record:
    kind: int
    start: int  # [bytes] from the beginning of the file
    end: int
    content: bytes

    def as_chunk(self) -> Chunk:
        """A chunk of it alone."""
        data = _HEAD.pack(self.kind, len(self.content)) + self.content
        return Chunk("", data, 0, 0, 0, len(data))


@dataclass
class _Tally:
    """Messages by channel, and when they were."""

    counts: Counter[int] = field(default_factory=Counter)
    start: int = (1 << 64) - 1  # [ns]
    end: int = 0  # [ns]


def scan(stream: IO[bytes]) -> Scan:
    """Find all whole chunks of a file.

    Raises:
        McapError: It is no MCAP file, or has a record that is too large.
    """
    size = stream.seek(0, os.SEEK_END)
    summary, end = Summary(), len(MCAP0_MAGIC)
    tally = _Tally()
    for record in _records(stream, size):
        match record.kind:
            case Opcode.CHUNK:
                chunk = Chunk.read(ReadDataStream(BytesIO(record.content)))
                try:
                    _note(breakup_chunk(chunk, validate_crc=True), summary, tally)
                except CRCValidationError:
                    break
                summary.chunk_indexes.append(_index(chunk, record))
            case Opcode.SCHEMA | Opcode.CHANNEL | Opcode.MESSAGE:
                _note(breakup_chunk(record.as_chunk()), summary, tally)
            case Opcode.MESSAGE_INDEX if summary.chunk_indexes:
                _note_message_index(record, summary.chunk_indexes[-1])
            case Opcode.DATA_END:
                break
        end = record.end
    summary.statistics = Statistics(
        attachment_count=0,
        channel_count=len(summary.channels),
        channel_message_counts=dict(tally.counts),
        chunk_count=len(summary.chunk_indexes),
        message_count=tally.counts.total(),
        message_end_time=tally.end,
        message_start_time=tally.start if tally.counts else 0,
        metadata_count=0,
        schema_count=len(summary.schemas),
    )
    return Scan(summary, end, size)


def mend(path: Path) -> Scan:
    """Make a file whole that ends in the middle: cut off what is no whole chunk, and put its index at the end.

    Raises:
        McapError: It is no MCAP file.
        OSError: It cannot be read or written.
    """
    with path.open("r+b") as stream:
        found = scan(stream)
        stream.truncate(found.end)
        stream.seek(found.end)
        stream.write(_ending(found))
    return found


def is_whole(stream: IO[bytes]) -> bool:
    """Whether a file ends as MCAP files do."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(max(0, size - len(MCAP0_MAGIC)))
    return size > 2 * len(MCAP0_MAGIC) and stream.read() == MCAP0_MAGIC


def _records(stream: IO[bytes], size: int) -> Iterator[_Record]:
    """The records that are there as a whole."""
    stream.seek(0)
    if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise McapError("it does not begin as MCAP files do")
    start = stream.tell()
    while len(head := stream.read(_HEAD.size)) == _HEAD.size:
        kind, length = _HEAD.unpack(head)
        end = start + _HEAD.size + length
        if end > size:
            return
        if length > MOST_RECORD:
            raise McapError(f"it has a record of {length:,} bytes; {MOST_RECORD:,} are read at most")
        yield _Record(kind, start, end, stream.read(length))
        start = end


def _note(records: Iterable[McapRecord], summary: Summary, tally: _Tally) -> None:
    for record in records:
        match record:
            case Schema():
                summary.schemas[record.id] = record
            case Channel():
                summary.channels[record.id] = record
            case Message():
                tally.counts[record.channel_id] += 1
                tally.start = min(tally.start, record.log_time)
                tally.end = max(tally.end, record.log_time)


def _index(chunk: Chunk, record: _Record) -> ChunkIndex:
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


def _note_message_index(record: _Record, chunk: ChunkIndex) -> None:
    index = MessageIndex.read(ReadDataStream(BytesIO(record.content)))
    chunk.message_index_offsets[index.channel_id] = record.start
    chunk.message_index_length += record.end - record.start


def _ending(found: Scan) -> bytes:
    """What stands after the last chunk of a whole file."""
    builder, summary = RecordBuilder(), found.summary
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
