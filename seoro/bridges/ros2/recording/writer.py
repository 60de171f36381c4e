"""Writer of bags: a folder in the format of rosbag2, with one MCAP or SQLite file.

Messages are queued and written by a thread, so that a slow disk does not block the event loop. A message is passed
to the operating system `PERIOD` later, or as soon as `CHUNK` bytes are queued. If the process is killed, the file
can be read up to there. The queue is bounded: when it is full, messages are dropped, counted and noted in the bag.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections import Counter, deque
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from datetime import datetime
from pathlib import Path
from typing import Final

import anyio
import anyio.to_thread

from seoro.bridges.ros2.recording.errors import RecordingFailed, RefusedRecording, UnreadableBag
from seoro.bridges.ros2.recording.mcap_file import CHUNK, Compression, McapFile
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic, write_metadata
from seoro.bridges.ros2.recording.reader import repair_bag
from seoro.bridges.ros2.recording.sqlite_file import STORAGE, SqliteFile

PERIOD: Final = 0.5  # [s] in the queue
METADATA_PERIOD: Final = 5.0  # [s] between updates of metadata.yaml
MAX_WAITING: Final = 256 * 1024 * 1024  # [bytes] of the queue
LOST: Final = "lost"  # name of the note about dropped messages
DEFAULT_NAME: Final = "rosbag2"
STORAGES: Final = {"": "mcap", "mcap": "mcap", STORAGE: "db3"}  # endings of files; the empty name is the default

_Queued = BagMessage | tuple[BagTopic, str]  # a message, or a topic with the definition of its type


def bag_folder(parent: Path, name: str = DEFAULT_NAME, at: datetime | None = None) -> Path:
    """Return the folder of a new bag.

    Args:
        parent: Parent folder of bags.
        name: Name of the bag.
        at: Time in the name of the folder, as by rosbag2 (`rosbag2_2024_05_31-16_04_05`); None for no time.
    """
    return parent / (name if at is None else f"{name}_{at:%Y_%m_%d-%H_%M_%S}")


def _check_storage(storage: str, compression: Compression) -> None:
    if storage not in STORAGES:
        raise RefusedRecording(
            f"unsupported storage `{storage}`: expected `mcap` or `{STORAGE}`", help="leave it out for `mcap`"
        )
    if storage == STORAGE and compression != "none":
        raise RefusedRecording(f"unsupported compression of `{STORAGE}`", help="leave it out, or record MCAP")


class BagWriter:
    """Writer of a bag. Made by `write_bag`; methods may be called from any thread.

    Attributes:
        folder: Folder of the bag.
        file: File in the folder.
    """

    def __init__(self, folder: Path, storage: str, compression: Compression, most_waiting: int) -> None:
        self.folder = folder
        self.file = folder / f"{folder.name}_0.{STORAGES[storage]}"
        self._most_waiting = most_waiting
        self._content = SqliteFile(self.file) if storage == STORAGE else McapFile(self.file, compression)
        self._changed = threading.Condition()
        self._waiting: deque[_Queued] = deque()
        self._size = 0  # [bytes] in the queue
        self._writing = 0  # [bytes] taken from the queue and not written yet
        self._closing = False
        self._lost: Counter[str] = Counter()
        self._notes: dict[str, str] = {}
        self._error: RecordingFailed | None = None
        self._loop = asyncio.get_running_loop()
        self._failed = asyncio.Event()
        self._write_metadata()
        self._thread = threading.Thread(target=self._run, name=f"writes {folder.name}", daemon=True)
        self._thread.start()

    @property
    def lost(self) -> Mapping[str, int]:
        """Number of dropped messages by topic."""
        return dict(self._lost)

    def add_topic(self, topic: BagTopic, definition: str) -> None:
        """Add a topic, before its first message.

        Args:
            topic: Description of the topic.
            definition: Definition of its type (`TypeStore.schema`); empty if it is unknown.
        """
        with self._changed:
            self._waiting.append((topic, definition))
            self._changed.notify()

    def write(self, topic: str, payload: bytes, received: int, sent: int | None = None, sequence: int = 0) -> bool:
        """Queue a message of an added topic, without waiting.

        Args:
            topic: Full name of the topic.
            payload: CDR, with its header.
            received: Time of arrival [ns since the epoch].
            sent: Time of sending [ns since the epoch]; None for the time of arrival.
            sequence: Sequence number of the sender, if any.

        Returns:
            Whether the message was queued, and not dropped.

        Raises:
            RecordingFailed: The bag can no longer be written.
        """
        message = BagMessage(topic, payload, received, received if sent is None else sent, sequence)
        with self._changed:
            if self._error is not None:
                raise self._error
            if self._size + self._writing + len(payload) > self._most_waiting:
                self._lost[topic] += 1
                return False
            self._waiting.append(message)
            self._size += len(payload)
            if len(self._waiting) == 1 or self._size >= CHUNK:
                self._changed.notify()
        return True

    def count_lost(self, topic: str, count: int) -> None:
        """Count messages of a topic that were lost before writing."""
        with self._changed:
            self._lost[topic] += count

    def note(self, name: str, text: str) -> None:
        """Write a note into the bag (`custom_data`), replacing that of the same name."""
        with self._changed:
            self._notes[name] = text

    async def wait_failed(self) -> None:
        """Wait for a failure.

        Raises:
            RecordingFailed: The bag can no longer be written.
        """
        await self._failed.wait()
        assert self._error is not None
        raise self._error

    async def finish(self) -> None:
        """Write the queue, and complete the bag.

        Raises:
            RecordingFailed: Some messages could not be written.
        """
        with self._changed:
            self._closing = True
            self._changed.notify()
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(self._thread.join)
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        try:
            is_last = False
            while not is_last:
                batch, is_last = self._next_batch()
                for each in batch:
                    if isinstance(each, BagMessage):
                        self._content.add_message(each)
                    else:
                        self._content.add_topic(*each)
                self._content.flush()
                self._writing = 0
                is_new = any(isinstance(each, tuple) for each in batch)
                if is_new or time.monotonic() - self._metadata_written > METADATA_PERIOD:
                    self._write_metadata()
            self._content.finish(self._all_notes())
            self._write_metadata()
        except Exception as error:
            self._fail(error)

    def _next_batch(self) -> tuple[list[_Queued], bool]:
        with self._changed:
            while not self._waiting and not self._closing:
                self._changed.wait()
            due = time.monotonic() + PERIOD
            while self._size < CHUNK and not self._closing and (left := due - time.monotonic()) > 0:
                self._changed.wait(left)
            batch = list(self._waiting)
            self._waiting.clear()
            self._size, self._writing = 0, self._size
            return batch, self._closing

    def _all_notes(self) -> dict[str, str]:
        with self._changed:
            lost = {LOST: ", ".join(f"{count} of {topic}" for topic, count in sorted(self._lost.items()))}
            return {**self._notes, **(lost if self._lost else {})}

    def _write_metadata(self) -> None:
        write_metadata(self.folder, self._content.information(self._all_notes()))
        self._metadata_written = time.monotonic()

    def _fail(self, error: Exception) -> None:
        """Close the bag so that it can be read, and report the failure."""
        self._content.abandon()
        with contextlib.suppress(OSError, UnreadableBag):  # without disk space for the index, the bag is readable
            repair_bag(self.folder)
        problem = error.strerror if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
        failed = RecordingFailed(f"cannot write {self.file} any more: {problem}")
        failed.__cause__ = error
        with self._changed:
            self._lost.update(each.topic for each in self._waiting if isinstance(each, BagMessage))
            self._waiting.clear()
            self._size = 0
            self._error = failed
        with contextlib.suppress(RuntimeError):  # the loop may be closed
            self._loop.call_soon_threadsafe(self._failed.set)


@asynccontextmanager
async def write_bag(
    folder: Path, *, storage: str = "", compression: Compression = "none", most_waiting: int = MAX_WAITING
) -> AsyncIterator[BagWriter]:
    """Write a bag during the block.

    Args:
        folder: Folder of the bag, which must not exist.
        storage: Storage format, by its rosbag2 name; empty for MCAP.
        compression: Compression of the messages in an MCAP file.
        most_waiting: Size limit of the queue [bytes].

    Raises:
        RefusedRecording: The folder exists, or cannot be created, or the format is unsupported.
        RecordingFailed: Some messages could not be written.
    """
    _check_storage(storage, compression)
    try:
        await anyio.Path(folder).mkdir(parents=True)
        writer = BagWriter(folder, storage, compression, most_waiting)
    except FileExistsError:
        raise RefusedRecording(f"{folder} exists; expected a new folder") from None
    except OSError as error:
        raise RefusedRecording(f"cannot create {folder}: {error.strerror}") from None
    try:
        yield writer
    except BaseException:
        with contextlib.suppress(RecordingFailed):  # the exception of the block has more details
            await writer.finish()
        raise
    await writer.finish()
