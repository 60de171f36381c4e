"""Writer of an SQLite file in the format of rosbag2 (storage `sqlite3`, version 4 of its tables).

Flushed messages are committed, so that they can be read if the process is killed.
"""

from __future__ import annotations

import contextlib
import sqlite3
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from seoro.bridges.ros2.recording.mcap_file import CHUNK
from seoro.bridges.ros2.recording.metadata import (
    VERSION,
    BagMessage,
    BagTopic,
    Extent,
    dump,
    information,
)
from seoro.bridges.ros2.recording.profiles import profile

_TABLES: Final = """
PRAGMA synchronous = OFF;
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
  data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema(schema_version, ros_distro) VALUES (4, 'unknown');
"""
STORAGE: Final = "sqlite3"


class SqliteFile:
    """A new SQLite file, with the methods of `McapFile`. Methods raise `sqlite3.Error` if a write fails.

    Args:
        path: Path of the file, which must not exist.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        path.touch(exist_ok=False)
        self._database = sqlite3.connect(path, check_same_thread=False)  # made by one thread, used by another
        self._database.executescript(_TABLES)
        self._types: set[str] = set()
        self._topics: list[BagTopic] = []
        self._ids: dict[str, int] = {}
        self._counts: Counter[str] = Counter()
        self._extent = Extent()
        self._uncommitted = 0  # [bytes]

    def information(self, notes: Mapping[str, str]) -> dict[str, Any]:
        """Return the entry of `metadata.yaml` for the file so far; see `McapFile`."""
        topics = [replace(topic, count=self._counts[topic.name]) for topic in self._topics]
        return information({self._path.name: self._extent}, topics, notes, storage=STORAGE)

    def add_topic(self, topic: BagTopic, definition: str) -> None:
        """Add a topic, before its first message; see `McapFile`."""
        if topic.type not in self._types:
            self._types.add(topic.type)
            encoding = "ros2msg" if definition else "unknown"
            self._insert("message_definitions", topic.type, encoding, definition, topic.type_hash)
        qos = dump([profile(qos) for qos in topic.qos]) if topic.qos else ""
        self._ids[topic.name] = self._insert("topics", topic.name, topic.type, "cdr", qos, topic.type_hash)
        self._topics.append(topic)

    def add_message(self, message: BagMessage) -> None:
        """Add a message of a topic. The format has times of arrival only."""
        received = message.received
        self._extent = self._extent | Extent(received, received, 1)
        self._counts[message.topic] += 1
        self._insert("messages", self._ids[message.topic], received, message.payload)
        self._uncommitted += len(message.payload)
        if self._uncommitted >= CHUNK:  # a failed write costs no more than this
            self.flush()

    def _insert(self, table: str, *values: object) -> int:
        """Insert a row, and return its ID."""
        marks = ", ".join("?" * len(values))
        row = self._database.execute(f"INSERT INTO {table} VALUES (NULL, {marks})", values)  # noqa: S608 - own names
        assert row.lastrowid is not None
        return row.lastrowid

    def flush(self) -> None:
        """Commit all added messages."""
        self._database.commit()
        self._uncommitted = 0

    def finish(self, notes: Mapping[str, str]) -> None:
        """Complete the file with a record of the content of `metadata.yaml`."""
        self._insert("metadata", VERSION, dump(self.information(notes)))
        self._database.commit()
        self._database.close()

    def abandon(self) -> None:
        """Close the incomplete file after an error."""
        with contextlib.suppress(sqlite3.Error):
            self._database.close()
