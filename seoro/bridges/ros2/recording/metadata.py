"""`metadata.yaml`, the description of a bag for the tools of ROS 2 (rosbag2, version 9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Any, Final

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.profiles import profile, read_profiles
from seoro.bridges.ros2.wire import Qos
from seoro.files.inputs import Kind, read_input_text

FILE_NAME: Final = "metadata.yaml"
ROOT: Final = "rosbag2_bagfile_information"
VERSION: Final = 9

# The C part of PyYAML is ten times as fast, if it is available.
_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class BagTopic:
    """A topic of a bag.

    Attributes:
        name: Full name of the topic.
        type: Full name of the type of the messages.
        type_hash: Hash of the type; empty if it is unknown.
        qos: QoS profiles of the publishers.
        count: Number of messages.
        definition: Definition of the type in a bag that was read, as `ros2msg`; empty if it is missing.
    """

    name: str
    type: str
    type_hash: str = ""
    qos: tuple[Qos, ...] = ()
    count: int = 0
    definition: str = field(default="", compare=False, repr=False)


@dataclass(frozen=True)
class Extent:
    """Time range and number of messages.

    Attributes:
        start: Time of the earliest message [ns since the epoch]; 0 without messages.
        end: Time of the latest message [ns since the epoch].
        count: Number of messages.
    """

    start: int = 0
    end: int = 0
    count: int = 0

    def __or__(self, other: Extent) -> Extent:
        """Return the union of two extents."""
        if not self.count or not other.count:
            return self if self.count else other
        return Extent(min(self.start, other.start), max(self.end, other.end), self.count + other.count)


@dataclass(frozen=True, slots=True)
class BagMessage:
    """A message of a bag.

    Attributes:
        topic: Full name of the topic.
        payload: CDR, with its header.
        received: Time of arrival [ns since the epoch], by the clock of the recorder.
        sent: Time of sending [ns since the epoch], by the clock of the sender, if known.
        sequence: Sequence number of the sender, in recordings.
    """

    topic: str
    payload: bytes
    received: int
    sent: int
    sequence: int = 0


def write_metadata(folder: Path, information: Mapping[str, Any]) -> None:
    """Replace `metadata.yaml` atomically.

    Args:
        folder: Folder of the bag.
        information: Content (`information`).

    Raises:
        OSError: The file cannot be written.
    """
    temporary = folder / f".{FILE_NAME}"
    temporary.write_text(dump({ROOT: information}), encoding="utf-8")
    temporary.replace(folder / FILE_NAME)


def information(
    files: Mapping[str, Extent], topics: Sequence[BagTopic], notes: Mapping[str, str], *, storage: str = "mcap"
) -> dict[str, Any]:
    """Return the content of `metadata.yaml`.

    Args:
        files: Extents of the files, by name.
        topics: Topics of all files.
        notes: Further notes, by name (`custom_data`).
        storage: Storage format of the files, by its rosbag2 name.
    """
    return {
        "version": VERSION,
        "storage_identifier": storage,
        **_times(reduce(or_, files.values())),
        "topics_with_message_count": [
            {"topic_metadata": _topic(topic), "message_count": topic.count} for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": list(files),
        "files": [{"path": name, **_times(extent)} for name, extent in files.items()],
        "custom_data": dict(notes) or None,
        "ros_distro": "unknown",
    }


def dump(data: Any) -> str:
    """Dump YAML without sorting keys."""
    text: str = yaml.dump(data, Dumper=_Unshared, sort_keys=False, allow_unicode=True, width=1000)
    return text


def _times(extent: Extent) -> dict[str, Any]:
    return {
        "duration": {"nanoseconds": extent.end - extent.start},
        "starting_time": {"nanoseconds_since_epoch": extent.start},
        "message_count": extent.count,
    }


def _topic(topic: BagTopic) -> dict[str, Any]:
    return {
        "name": topic.name,
        "type": topic.type,
        "serialization_format": "cdr",
        "offered_qos_profiles": [profile(qos) for qos in topic.qos],
        "type_description_hash": topic.type_hash,
    }


class _Unshared(_Dumper):  # type: ignore[misc]
    """YAML dumper that writes repeated values in full, without aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


class _TopicMetadata(BaseModel):
    name: str
    type: str
    offered_qos_profiles: str | list[Any] = ""
    type_description_hash: str = ""


class _Counted(BaseModel):
    topic_metadata: _TopicMetadata
    message_count: int = 0


class Metadata(BaseModel):
    """Part of `metadata.yaml`, of any version, that is needed to read a bag."""

    model_config = ConfigDict(extra="ignore")

    version: int
    storage_identifier: str
    relative_file_paths: list[str] = Field(min_length=1)
    topics_with_message_count: list[_Counted] = []
    custom_data: dict[str, str] | None = None
    compression_format: str | None = None
    compression_mode: str | None = None

    @property
    def is_compressed(self) -> bool:
        """Whether rosbag2 itself has compressed files or messages."""
        return (self.compression_mode or "none").lower() != "none"

    def topics(self) -> dict[str, BagTopic]:
        """Return the topics by name.

        Raises:
            ValueError: A QoS profile is invalid.
        """
        return {
            each.topic_metadata.name: BagTopic(
                each.topic_metadata.name,
                each.topic_metadata.type,
                each.topic_metadata.type_description_hash,
                read_profiles(each.topic_metadata.offered_qos_profiles),
                each.message_count,
            )
            for each in self.topics_with_message_count
        }


def read_metadata(folder: Path) -> Metadata | None:
    """Read `metadata.yaml` in a folder; return None without one.

    Raises:
        UnreadableBag: The file is invalid.
    """
    path = folder / FILE_NAME
    try:
        data = yaml.load(read_input_text(path, Kind.METADATA), Loader=_Loader)  # noqa: S506 - a safe loader
        return Metadata.model_validate(data[ROOT])
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise UnreadableBag(f"cannot read {path}: {error}") from None
    except (KeyError, TypeError):
        raise UnreadableBag(f"{path}: missing `{ROOT}`") from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise UnreadableBag(f"{path}: {place}: {first['msg']}") from None
