"""Reader of bags: folders written by rosbag2 and seoro, and single files. Truncated bags are repaired.

MCAP files, complete or truncated, are read by `mcap_source.py`, other files by rosbags.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from seoro.bridges.ros2.interfaces.errors import near
from seoro.bridges.ros2.recording.errors import UnknownTopic, UnreadableBag
from seoro.bridges.ros2.recording.mcap_source import McapSource
from seoro.bridges.ros2.recording.metadata import (
    FILE_NAME,
    BagMessage,
    BagTopic,
    Extent,
    Metadata,
    information,
    read_metadata,
    write_metadata,
)
from seoro.bridges.ros2.recording.scanning import DAMAGES, is_whole, repair
from seoro.bridges.ros2.recording.sqlite_file import STORAGE
from seoro.bridges.ros2.recording.sqlite_mending import mend
from seoro.files.inputs import Kind, open_input

if TYPE_CHECKING:
    from seoro.bridges.ros2.recording.rosbags_source import RosbagsSource

    Source: TypeAlias = McapSource | RosbagsSource

MCAP: Final = ".mcap"
SQLITE: Final = ".db3"


@dataclass(frozen=True)
class Bag:
    """A bag. Made by `open_bag`.

    Attributes:
        path: Folder or file of the bag.
        topics: Topics by name.
        extent: Time range and number of messages.
        is_cut_off: Whether the bag is truncated; it can be played, and `repair_bag` completes it.
        notes: Notes in the metadata (`custom_data`), such as lost messages.
    """

    path: Path
    topics: dict[str, BagTopic]
    extent: Extent
    is_cut_off: bool
    notes: Mapping[str, str]
    _sources: tuple[Source, ...]

    def choose(self, names: Sequence[str]) -> tuple[BagTopic, ...]:
        """Select topics by name; all if no name is given.

        Raises:
            UnknownTopic: The bag lacks a topic; the help has similar names.
        """
        for name in names:
            if name not in self.topics:
                known = ", ".join(sorted(self.topics)) or "no topics"
                help_ = near(name, self.topics) or f"topics: {known}"
                raise UnknownTopic(f"{self.path} has no topic {name}", help=help_)
        return tuple(self.topics[name] for name in dict.fromkeys(names)) if names else tuple(self.topics.values())

    def messages(self, topics: Collection[str] | None = None, start: int = 0) -> Iterator[BagMessage]:
        """Yield the messages in the order of arrival.

        Args:
            topics: Full names of the topics to read; None for all.
            start: Time of the first message [ns since the epoch].

        Raises:
            UnreadableBag: A file is damaged.
        """
        for source in self._sources:
            yield from source.messages(topics, start)


def open_bag(path: Path) -> Bag:
    """Open a bag.

    Args:
        path: Folder of a bag, or a file `*.mcap` or `*.db3`.

    Raises:
        UnreadableBag: The bag is missing or unreadable.
    """
    metadata = None
    if path.is_dir():
        metadata = read_metadata(path)
        sources = _open_folder(path, metadata)
    elif path.is_file():
        sources = _open_files([path])
    else:
        raise _not_found(path)
    described = _described_topics(path, metadata)
    topics: dict[str, BagTopic] = {}
    for source in sources:
        for topic in source.topics:
            topics[topic.name] = _merged(path, topics.get(topic.name), topic, described.get(topic.name))
    extent = reduce(or_, (source.extent for source in sources))
    notes = (metadata.custom_data if metadata else None) or {}
    return Bag(path, topics, extent, any(source.is_cut_off for source in sources), notes, tuple(sources))


def repair_bag(path: Path) -> Bag:
    """Complete the files of a bag, so that all tools can read them, and rewrite its `metadata.yaml`.

    All readable messages are kept; only incomplete messages, and unfinished writes of SQLite, are removed.

    Args:
        path: Folder of a bag, or a file.

    Raises:
        UnreadableBag: The bag is missing, a file is neither MCAP nor SQLite, or the bag is still being written.
        OSError: The bag cannot be written.
    """
    files = _files_of(path) if path.is_dir() else [path]
    if not files or any(file.suffix not in _REPAIRS or not file.is_file() for file in files):
        raise UnreadableBag(f"{path} is not a bag of MCAP or SQLite files; only these can be repaired")
    for file in files:
        _REPAIRS[file.suffix](file)
    if path.is_dir():
        bag, extents = open_bag(path), {file.name: open_bag(file).extent for file in files}
        storage = STORAGE if files[0].suffix == SQLITE else "mcap"
        write_metadata(path, information(extents, list(bag.topics.values()), bag.notes, storage=storage))
    return open_bag(path)


def _repair_mcap(file: Path) -> None:
    try:
        with open_input(file, Kind.RECORDING) as stream:
            whole = is_whole(stream)
        if not whole:
            repair(file)
    except DAMAGES as error:
        raise UnreadableBag(f"{file} is damaged, or not an MCAP file: {error or type(error).__name__}") from None
    except BlockingIOError:
        raise UnreadableBag(f"{file} is still being written") from None


_REPAIRS: Final = {MCAP: _repair_mcap, SQLITE: mend}


def _files_of(folder: Path) -> list[Path]:
    """Return the MCAP files of a folder in the order of their numbers; without any, its SQLite files."""
    found = [*folder.glob(f"*{MCAP}")] or [*folder.glob(f"*{SQLITE}")]
    return sorted(found, key=lambda path: [_sort_key(part) for part in re.split(r"(\d+)", path.name)])


def _open_folder(folder: Path, metadata: Metadata | None) -> list[Source]:
    if metadata is None:
        files = _files_of(folder)
        if not files:
            raise UnreadableBag(f"{folder} is not a bag: expected {FILE_NAME}, or files {MCAP} or {SQLITE}")
        return _open_files(files)
    if metadata.storage_identifier != "mcap" or metadata.is_compressed:
        return [_open_with_rosbags(folder)]
    return _open_files([folder / Path(name).name for name in metadata.relative_file_paths])


def _open_files(files: Sequence[Path]) -> list[Source]:
    return [McapSource(file) if file.suffix == MCAP else _open_with_rosbags(file) for file in files]


def _open_with_rosbags(path: Path) -> Source:
    from seoro.bridges.ros2.recording.rosbags_source import RosbagsSource  # noqa: PLC0415 - imports rosbags

    return RosbagsSource(path)


def _described_topics(path: Path, metadata: Metadata | None) -> dict[str, BagTopic]:
    if metadata is None:
        return {}
    try:
        return metadata.topics()
    except ValueError as error:
        raise UnreadableBag(f"{path / FILE_NAME}: {error}") from None


def _merged(path: Path, known: BagTopic | None, topic: BagTopic, described: BagTopic | None) -> BagTopic:
    """Merge the descriptions of a topic in several files and in the metadata of the bag."""
    if known is not None and known.type != topic.type:
        raise UnreadableBag(f"{path}: {topic.name} has the types {known.type} and {topic.type}")
    known = known or replace(topic, count=0)
    return replace(
        known,
        type_hash=known.type_hash or topic.type_hash or (described.type_hash if described else ""),
        qos=known.qos or topic.qos or (described.qos if described else ()),
        count=known.count + topic.count,
    )


def _sort_key(part: str) -> tuple[int, str]:
    return (int(part), "") if part.isdecimal() else (0, part)


def _not_found(path: Path) -> UnreadableBag:
    siblings = [each.name for each in path.parent.iterdir()] if path.parent.is_dir() else []
    return UnreadableBag(f"bag not found: {path}", help=near(path.name, siblings))
