"""Reader of SQLite bags, and of bags that rosbag2 itself has compressed, by rosbags."""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from sqlite3 import Error as SqliteError
from typing import Any, Final

from rosbags.interfaces import Connection, MessageDefinitionFormat, QosTime
from rosbags.rosbag2 import Reader, ReaderError

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic, Extent
from seoro.bridges.ros2.recording.profiles import read_profiles
from seoro.bridges.ros2.recording.sqlite_mending import check_complete

_DAMAGES: Final = (ReaderError, SqliteError, ValueError, KeyError, EOFError, struct.error)


class RosbagsSource:
    """A bag, or a file of a bag.

    Args:
        path: Folder or file.

    Raises:
        UnreadableBag: The bag is unreadable, or a write of an SQLite file is unfinished.
    """

    is_cut_off = False

    def __init__(self, path: Path) -> None:
        self.path = path
        for file in path.glob("*.db3") if path.is_dir() else [path]:
            check_complete(file)
        with self._reading() as reader:
            self.extent = Extent(reader.start_time, reader.end_time - 1, reader.message_count)
            if not reader.message_count:
                self.extent = Extent()
            self.topics = tuple(_topic(connection) for connection in reader.connections)

    def messages(self, topics: Collection[str] | None, start: int) -> Iterator[BagMessage]:
        """Yield the messages in the order of arrival; see `Bag.messages`."""
        with self._reading() as reader:
            chosen = [each for each in reader.connections if topics is None or each.topic in topics]
            if not chosen:
                return
            for connection, received, payload in reader.messages(chosen, start=start):
                yield BagMessage(connection.topic, bytes(payload), received, received)

    @contextmanager
    def _reading(self) -> Iterator[Reader]:
        try:
            with Reader(self.path) as reader:
                yield reader
        except OSError as error:
            raise UnreadableBag(f"cannot read {self.path}: {error}") from None
        except _DAMAGES as error:
            raise UnreadableBag(f"{self.path} is damaged, or not a bag: {error}") from None


def _topic(connection: Connection) -> BagTopic:
    profiles = [
        {name: _policy(value) for name, value in each._asdict().items()}
        for each in getattr(connection.ext, "offered_qos_profiles", ())
    ]
    is_text = connection.msgdef.format is MessageDefinitionFormat.MSG
    return BagTopic(
        connection.topic,
        connection.msgtype,
        connection.digest,
        read_profiles(profiles),
        connection.msgcount,
        connection.msgdef.data if is_text else "",
    )


def _policy(value: Any) -> Any:
    """Convert a policy of rosbags to its form in `metadata.yaml`."""
    match value:
        case Enum():
            return value.name.lower()
        case QosTime():
            return value._asdict()
        case _:
            return value
