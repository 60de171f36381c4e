"""What rmw_zenoh sends beside every message, request and response: its number, its time, and who sent it.

    int64 sequence number | int64 time [ns since the epoch] | length of the gid (16) | gid    (little endian)

A subscription of rmw_zenoh drops messages without it.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

GID_SIZE = 16

_HEAD = struct.Struct("<qqB")


class InvalidAttachment(ValueError):
    """What travelled beside a message is not what rmw_zenoh sends."""


class Attachment(NamedTuple):
    """The attachment of a message.

    Attributes:
        sequence: Counts what the sender has sent, from 1; a response has that of its request.
        stamp: [ns] since the epoch at which it was sent, by the sender's clock.
        gid: Who sent it: 16 bytes; a response has those of the client.
    """

    sequence: int
    stamp: int
    gid: bytes

    def pack(self) -> bytes:
        """The bytes on the wire."""
        return _HEAD.pack(self.sequence, self.stamp, len(self.gid)) + self.gid

    @classmethod
    def parse(cls, payload: bytes) -> Attachment:
        """Read it; what comes after the gid is left to versions to come.

        Raises:
            InvalidAttachment: It is too short for what it says.
        """
        if len(payload) < _HEAD.size:
            raise InvalidAttachment(
                f"an attachment of {len(payload)} bytes has no room for {_HEAD.size} bytes of head"
            )
        sequence, stamp, length = _HEAD.unpack_from(payload)
        gid = payload[_HEAD.size : _HEAD.size + length]
        if len(gid) < length:
            raise InvalidAttachment(f"an attachment announces a gid of {length} bytes and has {len(gid)}")
        return cls(sequence, stamp, gid)
