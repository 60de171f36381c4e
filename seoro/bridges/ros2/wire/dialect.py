"""Interface of the two mappings of ROS 2 to Zenoh."""

from __future__ import annotations

import re
from typing import Protocol

from seoro.bridges.ros2.wire.entities import Entity

_ROS_TYPE = re.compile(r"(\w+)/(\w+)/(\w+)")
_DDS_TYPE = re.compile(r"(\w+)::(\w+)::dds_::(\w+)_")


class Dialect(Protocol):
    """Mapping of ROS 2 to Zenoh."""

    @property
    def name(self) -> str:
        """Name on the command line."""

    @property
    def tokens(self) -> str:
        """Key expression of the liveliness tokens of all nodes and endpoints."""

    def token(self, entity: Entity) -> str | None:
        """Return the liveliness token of a node or endpoint; None if the dialect does not announce its kind."""

    def parse(self, token: str) -> Entity | None:
        """Parse a token; return None if it is not of this dialect."""

    def key(self, name: str, type_name: str, type_hash: str | None) -> str:
        """Return the key of a topic or service.

        Args:
            name: Full name of the topic or service.
            type_name: Type of the topic or service.
            type_hash: Hash of the type; None in systems without type hashes.
        """

    def key_expression(self, name: str, type_name: str) -> str:
        """Return the key expression of a topic or service, for all type hashes."""

    def type_hash(self, key: str) -> str | None:
        """Return the type hash in the key of a message; None without one."""

    def gid(self, token: str) -> bytes:
        """Return the GID of the endpoint of a token, which identifies it as the sender of messages."""

    def attachment(self, sequence: int, stamp: int, gid: bytes) -> bytes | None:
        """Make the attachment of a message (`Attachment`), or None if the dialect has none."""


def dds_type(name: str) -> str:
    """Return the DDS name of a type: `std_msgs::msg::dds_::String_` for `std_msgs/msg/String`."""
    match = _ROS_TYPE.fullmatch(name)
    return f"{match[1]}::{match[2]}::dds_::{match[3]}_" if match else name


def ros_type(name: str) -> str:
    """Return the ROS name of a DDS type."""
    match = _DDS_TYPE.fullmatch(name)
    return f"{match[1]}/{match[2]}/{match[3]}" if match else name
