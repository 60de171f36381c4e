"""What the two ways in which ROS 2 uses Zenoh have in common."""

from __future__ import annotations

import re
from typing import Protocol

from seoro.bridges.ros2.wire.entities import Entity

_ROS_TYPE = re.compile(r"(\w+)/(\w+)/(\w+)")
_DDS_TYPE = re.compile(r"(\w+)::(\w+)::dds_::(\w+)_")


class Dialect(Protocol):
    """One way in which ROS 2 systems use Zenoh."""

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    @property
    def tokens(self) -> str:
        """Key expression of the liveliness tokens from which everything is known that there is."""
        ...

    def token(self, entity: Entity) -> str | None:
        """The token by which something is announced, or None where such things are not announced."""
        ...

    def parse(self, token: str) -> Entity | None:
        """What a token announces, or None if it is none of this dialect."""
        ...

    def key(self, name: str, type_name: str, type_hash: str | None) -> str:
        """The key of a topic or service.

        Args:
            name: Full name.
            type_name: Of the topic's messages, or of the service.
            type_hash: Of the definition of the type; None in systems that have no hashes.
        """
        ...

    def every_key(self, name: str, type_name: str) -> str:
        """The key expression of a topic or service, however its type is defined."""
        ...

    def type_hash(self, key: str) -> str | None:
        """The hash of the type of what was published on a key, where keys tell."""
        ...

    def gid(self, token: str) -> bytes:
        """By what messages name the endpoint of a token as their sender."""
        ...

    def attachment(self, sequence: int, stamp: int, gid: bytes) -> bytes | None:
        """What is sent beside a message (`Attachment`), or None where nothing is."""
        ...


def dds_type(name: str) -> str:
    """How DDS calls a type: `std_msgs::msg::dds_::String_` for `std_msgs/msg/String`."""
    match = _ROS_TYPE.fullmatch(name)
    return f"{match[1]}::{match[2]}::dds_::{match[3]}_" if match else name


def ros_type(name: str) -> str:
    """How ROS calls a type that DDS names."""
    match = _DDS_TYPE.fullmatch(name)
    return f"{match[1]}/{match[2]}/{match[3]}" if match else name
