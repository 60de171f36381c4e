"""Reader of an MCAP file, complete or truncated."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.records import Channel
from mcap.summary import Summary
from mcap.well_known import MessageEncoding, SchemaEncoding

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic, Extent
from seoro.bridges.ros2.recording.profiles import read_profiles
from seoro.bridges.ros2.recording.scanning import DAMAGES, MAX_RECORD, is_whole, scan
from seoro.files.inputs import Kind, open_input


class McapSource:
    """An MCAP file.

    Args:
        path: The file.

    Raises:
        UnreadableBag: The file is unreadable, damaged or not an MCAP file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._reading() as stream:
            self.is_cut_off = not is_whole(stream)
            self._summary = summary = _summary(stream, self.is_cut_off)
            assert summary.statistics is not None
            if self.is_cut_off and summary.statistics.message_count and not summary.chunk_indexes:
                raise McapError("truncated file without chunks; repair it first")
            statistics = summary.statistics
            self.extent = Extent(
                statistics.message_start_time, statistics.message_end_time, statistics.message_count
            )
            counts = statistics.channel_message_counts
            self.topics = tuple(
                self._topic(channel, counts.get(channel.id, 0)) for channel in summary.channels.values()
            )

    def messages(self, topics: Collection[str] | None, start: int) -> Iterator[BagMessage]:
        """Yield the messages in the order of arrival.

        Args:
            topics: Topics to read; None for all.
            start: Time of the first message [ns since the epoch].

        Raises:
            UnreadableBag: The file is damaged.
        """
        if not self.extent.count:
            return
        with self._reading() as stream:
            reader = _Indexed(stream, self._summary)
            # Without an index, sorting would load the whole file.
            is_indexed = bool(self._summary.chunk_indexes)
            found = reader.iter_messages(topics=topics, starting_at=start, log_time_order=is_indexed)
            for _, channel, message in found:
                yield BagMessage(channel.topic, message.data, message.log_time, message.publish_time)

    @contextmanager
    def _reading(self) -> Iterator[IO[bytes]]:
        try:
            with open_input(self.path, Kind.RECORDING) as stream:
                yield stream
        except OSError as error:
            raise UnreadableBag(f"cannot read {self.path}: {error.strerror}") from None
        except DAMAGES as error:
            raise UnreadableBag(
                f"{self.path} is damaged, or not an MCAP file: {error or type(error).__name__}"
            ) from None

    def _topic(self, channel: Channel, count: int) -> BagTopic:
        if channel.message_encoding != MessageEncoding.CDR:
            raise McapError(f"{channel.topic} is encoded as {channel.message_encoding!r}, not as CDR")
        schema = self._summary.schemas.get(channel.schema_id)
        if schema is None:
            raise McapError(f"the type of {channel.topic} is missing")
        about = channel.metadata
        qos = read_profiles(about.get("offered_qos_profiles", ""))
        is_text = schema.encoding == SchemaEncoding.ROS2
        definition = schema.data.decode(errors="replace") if is_text else ""
        return BagTopic(channel.topic, schema.name, about.get("topic_type_hash", ""), qos, count, definition)


def _summary(stream: IO[bytes], is_cut_off: bool) -> Summary:
    """Return the index at the end of a file, or one made from its chunks."""
    if not is_cut_off:
        stream.seek(0)
        summary = SeekingReader(stream, record_size_limit=MAX_RECORD).get_summary()
        if summary is not None and summary.statistics is not None:
            return summary
    return scan(stream).summary


class _Indexed(SeekingReader):
    """Reader with a known index."""

    def __init__(self, stream: IO[bytes], summary: Summary) -> None:
        super().__init__(stream, validate_crcs=True, record_size_limit=MAX_RECORD)
        self._found = summary

    def get_summary(self) -> Summary:
        return self._found
