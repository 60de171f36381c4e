"""Reading bags: folders as rosbag2 and seoro write them, and single files.

MCAP files are read here, also those that end in the middle; the rest is left to rosbags.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Final

from seoro.bridges.ros2.interfaces.errors import near
from seoro.bridges.ros2.recording.errors import UnknownTopic, UnreadableBag
from seoro.bridges.ros2.recording.metadata import FILE_NAME, BagTopic, Extent, Metadata, read_metadata
from seoro.bridges.ros2.recording.sources import BagMessage, Source

MCAP: Final = ".mcap"
SQLITE: Final = ".db3"


@dataclass(frozen=True)
class Bag:
    """A bag that is there. Made by `open_bag`.

    Attributes:
        path: Folder or file.
        topics: What it has, by name.
        extent: How much there is.
        is_cut_off: Whether it ends in the middle; it can be played up to there, and `mend_bag` makes it whole.
        notes: What its metadata says beside that (`custom_data`), such as what was lost.
    """

    path: Path
    topics: dict[str, BagTopic]
    extent: Extent
    is_cut_off: bool
    notes: Mapping[str, str]
    _sources: tuple[Source, ...]

    def choose(self, names: Sequence[str]) -> tuple[BagTopic, ...]:
        """The topics of some names; all if there is none.

        Raises:
            UnknownTopic: It has no such topic; names those that come near.
        """
        for name in names:
            if name not in self.topics:
                known = ", ".join(sorted(self.topics)) or "no topics"
                help_ = near(name, self.topics) or f"it has {known}"
                raise UnknownTopic(f"{self.path} has no topic {name}", help=help_)
        return tuple(self.topics[name] for name in dict.fromkeys(names)) if names else tuple(self.topics.values())

    def messages(self, topics: Collection[str] | None = None, start: int = 0) -> Iterator[BagMessage]:
        """The messages in the order in which they were received. Reads as it goes.

        Args:
            topics: Of which, by full names; all when None.
            start: [ns] since the epoch, of the first.

        Raises:
            UnreadableBag: A file is damaged.
        """
        for source in self._sources:
            yield from source.messages(topics, start)


def open_bag(path: Path) -> Bag:
    """Find out what is in a bag.

    Args:
        path: The folder of a bag, or a file `*.mcap` or `*.db3`.

    Raises:
        UnreadableBag: There is none, or it cannot be read.
    """
    metadata = None
    if path.is_dir():
        metadata = read_metadata(path)
        sources = _of_folder(path, metadata)
    elif path.is_file():
        sources = _of_files([path])
    else:
        raise _no_bag(path)
    said = _said(path, metadata)
    topics: dict[str, BagTopic] = {}
    for source in sources:
        for topic in source.topics:
            topics[topic.name] = _together(path, topics.get(topic.name), topic, said.get(topic.name))
    extent = reduce(or_, (source.extent for source in sources))
    notes = (metadata.custom_data if metadata else None) or {}
    return Bag(path, topics, extent, any(source.is_cut_off for source in sources), notes, tuple(sources))


def files_of(folder: Path) -> list[Path]:
    """The MCAP files of a folder in the order in which they were written, whatever its metadata says."""
    return sorted(
        folder.glob(f"*{MCAP}"), key=lambda path: [_numbered(part) for part in re.split(r"(\d+)", path.name)]
    )


def _of_folder(folder: Path, metadata: Metadata | None) -> list[Source]:
    if metadata is None:
        files = files_of(folder) or sorted(folder.glob(f"*{SQLITE}"))
        if not files:
            raise UnreadableBag(f"{folder} is no bag: it has neither {FILE_NAME} nor files {MCAP} or {SQLITE}")
        return _of_files(files)
    if metadata.storage_identifier != "mcap" or metadata.is_compressed:
        return [_by_rosbags(folder)]
    return _of_files([folder / Path(name).name for name in metadata.relative_file_paths])


def _of_files(files: Sequence[Path]) -> list[Source]:
    from seoro.bridges.ros2.recording.mcap_source import McapSource  # noqa: PLC0415 - imports mcap

    return [McapSource(file) if file.suffix == MCAP else _by_rosbags(file) for file in files]


def _by_rosbags(path: Path) -> Source:
    from seoro.bridges.ros2.recording.rosbags_source import RosbagsSource  # noqa: PLC0415 - imports rosbags

    return RosbagsSource(path)


def _said(path: Path, metadata: Metadata | None) -> dict[str, BagTopic]:
    if metadata is None:
        return {}
    try:
        return metadata.topics()
    except ValueError as error:
        raise UnreadableBag(f"{path / FILE_NAME}: {error}") from None


def _together(path: Path, known: BagTopic | None, topic: BagTopic, said: BagTopic | None) -> BagTopic:
    """What several files, and the metadata of the bag, say of a topic."""
    if known is not None and known.type != topic.type:
        raise UnreadableBag(f"{path}: {topic.name} is of type {known.type} and of type {topic.type}")
    known = known or replace(topic, count=0)
    return replace(
        known,
        type_hash=known.type_hash or topic.type_hash or (said.type_hash if said else ""),
        qos=known.qos or topic.qos or (said.qos if said else ()),
        count=known.count + topic.count,
    )


def _numbered(part: str) -> tuple[int, str]:
    return (int(part), "") if part.isdecimal() else (0, part)


def _no_bag(path: Path) -> UnreadableBag:
    beside = [each.name for each in path.parent.iterdir()] if path.parent.is_dir() else []
    return UnreadableBag(f"there is no bag {path}", help=near(path.name, beside))
