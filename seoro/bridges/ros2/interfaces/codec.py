"""CDR, the format of messages on the wire, by the code generators of rosbags.

The type store of rosbags is not used: it has no services and actions, treats `byte` as a signed number, and
generates code for ROS 1 as well. `Codec` implements the protocol `rosbags.interfaces.Typestore`, which the
generators need. Code is generated when a type is encoded or decoded for the first time.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache, cached_property
from typing import Any, Final, cast

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.serde.cdr import generate_deserialize_cdr, generate_getsize_cdr, generate_serialize_cdr

from seoro.bridges.ros2.interfaces import definitions
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition, InvalidPayload, InvalidValue
from seoro.bridges.ros2.interfaces.messages import Message, attribute, message_class

MAX_PAYLOAD: Final = 128 * 1024 * 1024  # [bytes] of a sent or received message
_HEADER: Final = 4  # [bytes]; encapsulation format, and options that plain CDR does not use
_LITTLE: Final = b"\x00\x01\x00\x00"
# Other encapsulation formats, by half of their number in the header; an odd number means little-endian.
_FORMS: Final = {1: "PL_CDR", 3: "CDR2", 4: "D_CDR2", 5: "PL_CDR2"}
_PADDING: Final = 3  # [bytes]; some writers pad messages to a multiple of four
_OCTETS: Final = ("byte", "char")


class Codec:
    """Encoder and decoder of messages.

    Args:
        lookup: Returns a structure by its full name.
    """

    def __init__(self, lookup: Callable[[str], definitions.Structure]) -> None:
        self.max_sequence_length = MAX_PAYLOAD
        # Returns the coder of a structure; the generated code requires this name.
        self.get_msgdef = cache(lambda typename: _Coder(lookup(typename), self))

    def message_class(self, name: str) -> type[Message]:
        """Return the class of the messages of a structure."""
        return self.get_msgdef(name).message_class

    def encode(self, message: Message) -> bytes:
        """Encode a message, whose members have the right types, as little-endian CDR.

        Raises:
            InvalidValue: The message is larger than the limit.
        """
        name = message.__msgtype__
        coder = self.get_msgdef(name)
        size = _HEADER + coder.getsize_cdr(0, message, self)
        if size > MAX_PAYLOAD:
            raise InvalidValue(name, "", f"{size} bytes exceed the limit of {MAX_PAYLOAD}")
        payload = bytearray(size)
        payload[:_HEADER] = _LITTLE
        coder.serialize_cdr_le(memoryview(payload)[_HEADER:], 0, message, self)
        return bytes(payload)

    def decode(self, name: str, payload: bytes) -> Message:
        """Decode a message; its arrays are views of the payload.

        Raises:
            InvalidPayload: The payload is not a valid message of the type.
        """
        coder = self.get_msgdef(name)
        if len(payload) > MAX_PAYLOAD:
            raise InvalidPayload(f"{name}: {len(payload)} bytes exceed the limit of {MAX_PAYLOAD}")
        form = bytes(payload[:2])
        if len(payload) < _HEADER or form not in {b"\x00\x00", b"\x00\x01"}:
            raise InvalidPayload(f"{name}: {_wrong_header(payload)}")
        deserialize = coder.deserialize_cdr_le if form[1] else coder.deserialize_cdr_be
        body = memoryview(payload)[_HEADER:]
        try:
            message, end = deserialize(body, 0, coder.cls, self)
        except (SerdeError, struct.error, ValueError) as error:
            raise InvalidPayload(
                f"{name}: invalid or truncated message of {len(payload)} bytes: {error}"
            ) from None
        if end + _PADDING < len(body):
            raise InvalidPayload(
                f"{name}: the message ends after {_HEADER + end} of {len(payload)} bytes; the sender has another"
                " definition"
            )
        return cast("Message", message)


class _Coder:
    """Message definition for rosbags: a factory of messages, and their code, generated on demand."""

    def __init__(self, structure: definitions.Structure, codec: Codec) -> None:
        self.name = structure.name
        self.message_class = message_class(structure)
        self.cls = _maker(self.message_class)
        self.fields = [
            (attribute(field.name), _described(field.type, f"{structure.name}, `{field.name}`"))
            for field in definitions.wire_fields(structure)
        ]
        self._codec: Any = codec

    @cached_property
    def _sizes(self) -> tuple[Any, int]:
        return generate_getsize_cdr(self.fields, self._codec)

    @cached_property
    def getsize_cdr(self) -> Callable[[int, object, Codec], int]:
        """Function that computes the end of a message from its start."""
        return cast("Callable[[int, object, Codec], int]", self._sizes[0])

    @cached_property
    def size_cdr(self) -> int:
        """Size of all messages [bytes]; 0 if it varies."""
        return self._sizes[1]

    @cached_property
    def serialize_cdr_le(self) -> Any:
        """Function that writes a message in little-endian order."""
        return generate_serialize_cdr(self.fields, self._codec, "le")

    @cached_property
    def deserialize_cdr_le(self) -> Any:
        """Function that reads a message in little-endian order."""
        return generate_deserialize_cdr(self.fields, self._codec, "le")

    @cached_property
    def deserialize_cdr_be(self) -> Any:
        """Function that reads a message in big-endian order."""
        return generate_deserialize_cdr(self.fields, self._codec, "be")


def _maker(message: type[Message]) -> Callable[..., Message]:
    """Return a factory of messages that is faster than their class, which matters for small messages."""
    make = tuple.__new__
    return lambda *members: make(message, members)  # type: ignore[type-var]


def _described(type_: definitions.FieldType, place: str) -> Any:
    """Return the description of a type for rosbags."""
    match type_:
        case definitions.Array(element, length):
            return (Nodetype.ARRAY, (_element(element, place), length))
        case definitions.Sequence(element, bound):
            return (Nodetype.SEQUENCE, (_element(element, place), bound))
        case definitions.Scalar() | definitions.Named():
            return _element(type_, place)


def _element(element: definitions.Element, place: str) -> Any:
    match element:
        case definitions.Named(name):
            return (Nodetype.NAME, name)
        case definitions.Scalar("wstring"):
            raise InvalidDefinition(
                f"{place}: unsupported type `wstring`",
                help="its format differs between ROS 2 middlewares; use `string`, which is UTF-8",
            )
        case definitions.Scalar(name, bound):
            return (Nodetype.BASE, ("uint8" if name in _OCTETS else name, bound))


def _wrong_header(payload: bytes) -> str:
    if len(payload) < _HEADER:
        return f"truncated message of {len(payload)} bytes; expected a header of {_HEADER} bytes"
    known = _FORMS.get(payload[1] // 2) if payload[0] == 0 else None
    begins = bytes(payload[:_HEADER]).hex(" ")
    form = f" ({known})" if known else ""
    return f"the payload begins with {begins}{form}; expected plain CDR, which begins with 00 00 or 00 01"
