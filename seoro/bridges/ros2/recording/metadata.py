"""`metadata.yaml`, by which the tools of ROS 2 know what is in the folder of a bag (rosbag2, version 9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Any, Final

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from seoro.bridges.ros2.recording.errors import UnreadableBag
from seoro.bridges.ros2.recording.profiles import profile, read_profiles
from seoro.bridges.ros2.wire import Qos
from seoro.input_files import Kind, read_input_text

FILE_NAME: Final = "metadata.yaml"
ROOT: Final = "rosbag2_bagfile_information"
VERSION: Final = 9

# The C part of PyYAML, where there is one, writes and reads ten times as fast.
_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class BagTopic:
    """A topic of a bag.

    Attributes:
        name: Full name.
        type: Full name of the type of its messages.
        type_hash: Of the definition of the type; empty where that is not known.
        qos: What the publishers offered.
        count: Messages.
    """

    name: str
    type: str
    type_hash: str = ""
    qos: tuple[Qos, ...] = ()
    count: int = 0


@dataclass(frozen=True)
class Extent:
    """How much there is.

    Attributes:
        start: [ns] since the epoch, of the earliest message; 0 if there is none.
        end: [ns] since the epoch, of the latest message.
        count: Messages.
    """

    start: int = 0
    end: int = 0
    count: int = 0

    def __or__(self, other: Extent) -> Extent:
        """Both together."""
        if not self.count or not other.count:
            return self if self.count else other
        return Extent(min(self.start, other.start), max(self.end, other.end), self.count + other.count)


def write_metadata(folder: Path, information: Mapping[str, Any]) -> None:
    """Write `metadata.yaml`, of which there is the old one or the new one at any time.

    Args:
        folder: The bag.
        information: What it says (`information`).

    Raises:
        OSError: It cannot be written.
    """
    beside = folder / f".{FILE_NAME}"
    beside.write_text(dump({ROOT: information}), encoding="utf-8")
    beside.replace(folder / FILE_NAME)


def information(
    files: Mapping[str, Extent], topics: Sequence[BagTopic], notes: Mapping[str, str]
) -> dict[str, Any]:
    """What `metadata.yaml` says of a bag of MCAP files.

    Args:
        files: How much there is in each, by name.
        topics: What they have together.
        notes: What else there is to say, by name (`custom_data`).
    """
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
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
    """YAML, in the order in which things are said."""
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
    """Writes out what occurs more than once; yaml-cpp knows aliases, people need not."""

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
    """What of `metadata.yaml` is needed to read a bag, of any version."""

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
        """Whether files or messages are compressed in a way that the storage does not know of."""
        return (self.compression_mode or "none").lower() != "none"

    def topics(self) -> dict[str, BagTopic]:
        """The topics by name.

        Raises:
            ValueError: The QoS of one cannot be read.
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
    """What `metadata.yaml` in a folder says; None if there is none.

    Raises:
        UnreadableBag: It is not what rosbag2 writes.
    """
    path = folder / FILE_NAME
    try:
        data = yaml.load(read_input_text(path, Kind.METADATA), Loader=_Loader)  # noqa: S506 - a safe loader
        return Metadata.model_validate(data[ROOT])
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise UnreadableBag(f"{path}: it cannot be read: {error}") from None
    except (KeyError, TypeError):
        raise UnreadableBag(f"{path}: it has no `{ROOT}`") from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise UnreadableBag(f"{path}: {place}: {first['msg']}") from None
