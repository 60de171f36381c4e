"""Attachments of rmw_zenoh to messages, requests and responses: sequence number, time and sender.

    int64 sequence number | int64 time [ns since the epoch] | length of the GID (16) | GID    (little endian)

Subscriptions of rmw_zenoh drop messages without an attachment.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

_HEAD = struct.Struct("<qqB")


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
    def parse(cls, payload: bytes) -> Attachment | None:
        """Decode an attachment; return None if it is truncated.

        Bytes after the GID are ignored, for later versions of the format.
        """
        if len(payload) < _HEAD.size:
            return None
        sequence, stamp, length = _HEAD.unpack_from(payload)
        gid = payload[_HEAD.size : _HEAD.size + length]
        return None if len(gid) < length else cls(sequence, stamp, gid)
