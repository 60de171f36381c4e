"""Writing bags: a folder as rosbag2 makes it, with one MCAP file.

Messages are put down in memory and written by a thread, so that a slow disk holds up nobody. What was put down is
with the operating system `PERIOD` later, or as soon as there are `CHUNK` bytes of it, and a process that is killed
leaves a file that can be read up to there. Memory is bounded: a message for which there is no room is lost, which
is counted and written into the bag.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections import Counter, deque
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import anyio
import anyio.to_thread

from seoro.bridges.ros2.recording.errors import RecordingFailed, RefusedRecording, UnreadableBag
from seoro.bridges.ros2.recording.mcap_file import CHUNK, Compression, McapFile
from seoro.bridges.ros2.recording.mending import mend_bag
from seoro.bridges.ros2.recording.metadata import BagTopic, write_metadata

PERIOD: Final = 0.5  # [s] of the machine's clock that a message waits to be written
METADATA_PERIOD: Final = 5.0  # [s] between updates of metadata.yaml
MOST_WAITING: Final = 256 * 1024 * 1024  # [bytes]
LOST: Final = "lost"  # under which the bag says what was lost


@dataclass(frozen=True, slots=True)
class _Topic:
    topic: BagTopic
    definition: str


@dataclass(frozen=True, slots=True)
class _Message:
    topic: str
    payload: bytes
    received: int
    sent: int
    sequence: int


class BagWriter:
    """Writes a bag. Made by `write_bag`; methods are for any thread.

    Attributes:
        folder: The bag.
        file: The MCAP file in it.
    """

    def __init__(self, folder: Path, compression: Compression, most_waiting: int) -> None:
        self.folder = folder
        self.file = folder / f"{folder.name}_0.mcap"
        self._most_waiting = most_waiting
        self._mcap = McapFile(self.file, compression)
        self._channels: dict[str, int] = {}
        self._changed = threading.Condition()
        self._waiting: deque[_Topic | _Message] = deque()
        self._size = 0  # [bytes] of what waits
        self._writing = 0  # [bytes] of what is being written
        self._closing = False
        self._lost: Counter[str] = Counter()
        self._notes: dict[str, str] = {}
        self._error: RecordingFailed | None = None
        self._loop = asyncio.get_running_loop()
        self._failed = asyncio.Event()
        self._write_metadata()
        self._told = time.monotonic()
        self._thread = threading.Thread(target=self._work, name=f"writes {folder.name}", daemon=True)
        self._thread.start()

    @property
    def lost(self) -> Mapping[str, int]:
        """Messages for which there was no room, by topic."""
        return dict(self._lost)

    def add_topic(self, topic: BagTopic, definition: str) -> None:
        """Add a topic, before its first message.

        Args:
            topic: What to say of it.
            definition: Of its type with all that it refers to (`TypeStore.schema`); empty where it is not known.
        """
        with self._changed:
            self._waiting.append(_Topic(topic, definition))
            self._changed.notify()

    def write(self, topic: str, payload: bytes, received: int, sent: int | None = None, sequence: int = 0) -> bool:
        """Write a message of a topic that has been added; never waits.

        Args:
            topic: Full name.
            payload: CDR, with its header.
            received: [ns] since the epoch.
            sent: [ns] since the epoch; as received when None.
            sequence: Its number among those of its sender, where these are numbered.

        Returns:
            False if there is no room for it.

        Raises:
            RecordingFailed: Nothing can be written any more.
        """
        message = _Message(topic, payload, received, received if sent is None else sent, sequence)
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

    def lose(self, topic: str, count: int) -> None:
        """Say that messages of a topic were lost before they could be written."""
        with self._changed:
            self._lost[topic] += count

    def note(self, name: str, text: str) -> None:
        """Put what there is to say of the bag into it (`custom_data`), in the place of what had that name."""
        with self._changed:
            self._notes[name] = text

    async def wait_failed(self) -> None:
        """Wait until nothing can be written any more.

        Raises:
            RecordingFailed: When that is so.
        """
        await self._failed.wait()
        assert self._error is not None
        raise self._error

    async def finish(self) -> None:
        """Write what waits, and make the bag whole.

        Raises:
            RecordingFailed: Not everything could be written.
        """
        with self._changed:
            self._closing = True
            self._changed.notify()
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(self._thread.join)
        if self._error is not None:
            raise self._error

    def _work(self) -> None:
        try:
            is_last = False
            while not is_last:
                batch, is_last = self._next_batch()
                for each in batch:
                    self._put(each)
                self._mcap.flush()
                self._writing = 0
                is_new = any(isinstance(each, _Topic) for each in batch)
                if is_new or time.monotonic() - self._told > METADATA_PERIOD:
                    self._write_metadata()
            self._mcap.finish(self._all_notes())
            self._write_metadata()
        except Exception as error:
            self._give_up(error)

    def _next_batch(self) -> tuple[list[_Topic | _Message], bool]:
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

    def _put(self, each: _Topic | _Message) -> None:
        match each:
            case _Topic(topic, definition):
                self._channels[topic.name] = self._mcap.add_topic(topic, definition)
            case _Message(topic, payload, received, sent, sequence):
                self._mcap.add_message(self._channels[topic], payload, received, sent, sequence)

    def _all_notes(self) -> dict[str, str]:
        with self._changed:
            lost = {LOST: ", ".join(f"{count} of {topic}" for topic, count in sorted(self._lost.items()))}
            return {**self._notes, **(lost if self._lost else {})}

    def _write_metadata(self) -> None:
        write_metadata(self.folder, self._mcap.information(self._all_notes()))
        self._told = time.monotonic()

    def _give_up(self, error: Exception) -> None:
        """Leave a bag that can be read, and tell."""
        self._mcap.abandon()
        with contextlib.suppress(OSError, UnreadableBag):  # there may be no room for the index: it is read without
            mend_bag(self.folder)
        problem = error.strerror if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
        failed = RecordingFailed(f"{self.file} cannot be written any more: {problem}")
        failed.__cause__ = error
        with self._changed:
            self._lost.update(each.topic for each in self._waiting if isinstance(each, _Message))
            self._waiting.clear()
            self._size = 0
            self._error = failed
        with contextlib.suppress(RuntimeError):  # the loop may be gone
            self._loop.call_soon_threadsafe(self._failed.set)


@asynccontextmanager
async def write_bag(
    folder: Path, *, compression: Compression = "none", most_waiting: int = MOST_WAITING
) -> AsyncIterator[BagWriter]:
    """Write a bag for as long as the block lasts.

    Args:
        folder: The bag, which is made; nothing may be there.
        compression: Of the messages in the file.
        most_waiting: [bytes] of messages that may wait to be written.

    Raises:
        RefusedRecording: The folder is there, or cannot be made.
        RecordingFailed: Not everything could be written.
    """
    try:
        await anyio.Path(folder).mkdir(parents=True)
        writer = BagWriter(folder, compression, most_waiting)
    except FileExistsError:
        raise RefusedRecording(f"{folder} exists; a bag is written into a folder of its own") from None
    except OSError as error:
        raise RefusedRecording(f"{folder} cannot be made: {error.strerror}") from None
    try:
        yield writer
    except BaseException:
        with contextlib.suppress(RecordingFailed):  # what ended the block says more
            await writer.finish()
        raise
    await writer.finish()
