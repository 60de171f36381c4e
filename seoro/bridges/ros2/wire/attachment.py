"""Attachments of rmw_zenoh to messages, requests and responses: sequence number, time and sender.

    int64 sequence number | int64 time [ns since the epoch] | length of the GID (16) | GID    (little endian)

Subscriptions of rmw_zenoh drop messages without an attachment.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

_HEAD = struct.Struct("<qqB")


class InvalidAttachment(ValueError):
    """The attachment of a message is not in the format of rmw_zenoh."""


class Attachment(NamedTuple):
    """Attachment of a message.

    Attributes:
        sequence: Sequence number of the sender, from 1; in a response, that of the request.
        stamp: Time of sending [ns since the epoch], by the clock of the sender.
        gid: GID of the sender: 16 bytes; in a response, that of the client.
    """

    sequence: int
    stamp: int
    gid: bytes

    def pack(self) -> bytes:
        """Encode the attachment."""
        return _HEAD.pack(self.sequence, self.stamp, len(self.gid)) + self.gid

    @classmethod
    def parse(cls, payload: bytes) -> Attachment:
        """Decode an attachment; bytes after the GID are ignored, for later versions of the format.

        Raises:
            InvalidAttachment: The attachment is truncated.
        """
        if len(payload) < _HEAD.size:
            raise InvalidAttachment(
                f"truncated attachment: expected {_HEAD.size} bytes or more, got {len(payload)}"
            )
        sequence, stamp, length = _HEAD.unpack_from(payload)
        gid = payload[_HEAD.size : _HEAD.size + length]
        if len(gid) < length:
            raise InvalidAttachment(f"truncated attachment: expected a GID of {length} bytes, got {len(gid)}")
        return cls(sequence, stamp, gid)
