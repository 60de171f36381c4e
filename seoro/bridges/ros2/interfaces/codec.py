"""CDR, the format of messages on the wire, by the generators of rosbags.

rosbags' type store is not used: it knows no services and actions, takes `byte` for a signed number, and generates
code for ROS 1 as well. What its generators ask of a type store is the protocol `rosbags.interfaces.Typestore`,
which is `Codec` here. Code is generated for what is encoded or decoded, when it is the first time.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cached_property
from typing import Any, Final, cast

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.serde.cdr import generate_deserialize_cdr, generate_getsize_cdr, generate_serialize_cdr

from seoro.bridges.ros2.interfaces.definitions import (
    Array,
    Element,
    FieldType,
    Named,
    Scalar,
    Sequence,
    Structure,
    wire_fields,
)
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition, InvalidPayload, InvalidValue
from seoro.bridges.ros2.interfaces.messages import Message, attribute, message_class

MAX_PAYLOAD: Final = 128 * 1024 * 1024  # [bytes]; of a message, in both directions
_HEADER: Final = 4  # [bytes]; which form follows, and options that plain CDR does not use
_LITTLE: Final = b"\x00\x01\x00\x00"
# Other forms by half of the number that the header has for them; whether that is odd says the byte order.
_FORMS: Final = {1: "PL_CDR", 3: "CDR2", 4: "D_CDR2", 5: "PL_CDR2"}
_PADDING: Final = 3  # [bytes]; some writers pad messages to a multiple of four
_OCTETS: Final = ("byte", "char")


class Codec:
    """Encodes and decodes structures.

    Args:
        lookup: Gives structures by their full names.
    """

    def __init__(self, lookup: Callable[[str], Structure]) -> None:
        self.max_sequence_length = MAX_PAYLOAD
        self._lookup = lookup
        self._coders: dict[str, _Coder] = {}

    def message_class(self, name: str) -> type[Message]:
        """The class of the messages of a structure."""
        return self.get_msgdef(name).message_class

    def encode(self, message: Message) -> bytes:
        """The little-endian CDR of a message whose members are of the right kinds.

        Raises:
            InvalidValue: It is larger than the limit.
        """
        name = message.__msgtype__
        coder = self.get_msgdef(name)
        size = _HEADER + coder.getsize_cdr(0, message, self)
        if size > MAX_PAYLOAD:
            raise InvalidValue(name, "", f"{size} bytes are more than the {MAX_PAYLOAD} of the limit")
        payload = bytearray(size)
        payload[:_HEADER] = _LITTLE
        coder.serialize_cdr_le(memoryview(payload)[_HEADER:], 0, message, self)
        return bytes(payload)

    def decode(self, name: str, payload: bytes) -> Message:
        """The message in a payload; its arrays are views of the payload.

        Raises:
            InvalidPayload: The payload is no message of that type.
        """
        coder = self.get_msgdef(name)
        if len(payload) > MAX_PAYLOAD:
            raise InvalidPayload(f"{name}: {len(payload)} bytes are more than the {MAX_PAYLOAD} of the limit")
        form = bytes(payload[:2])
        if len(payload) < _HEADER or form not in {b"\x00\x00", b"\x00\x01"}:
            raise InvalidPayload(f"{name}: {_wrong_header(payload)}")
        deserialize = coder.deserialize_cdr_le if form[1] else coder.deserialize_cdr_be
        body = memoryview(payload)[_HEADER:]
        try:
            message, end = deserialize(body, 0, coder.cls, self)
        except (SerdeError, struct.error, ValueError) as error:
            raise InvalidPayload(
                f"{name}: the {len(payload)} bytes are no such message, or a truncated one: {error}"
            ) from None
        if end + _PADDING < len(body):
            raise InvalidPayload(
                f"{name}: the message ends after {_HEADER + end} of {len(payload)} bytes; the sender has another"
                " definition of it"
            )
        return cast("Message", message)

    def get_msgdef(self, typename: str) -> _Coder:
        """What codes a structure. The name is that of rosbags' protocol, whose generated code calls it."""
        coder = self._coders.get(typename)
        if coder is None:
            coder = self._coders[typename] = _Coder(self._lookup(typename), self)
        return coder


class _Coder:
    """What rosbags calls the definition of a message: what makes one, and the code for it, generated on demand."""

    def __init__(self, structure: Structure, codec: Codec) -> None:
        self.name = structure.name
        self.message_class = message_class(structure)
        self.cls = _maker(self.message_class)
        self.fields = [
            (attribute(field.name), _described(field.type, f"{structure.name}, `{field.name}`"))
            for field in wire_fields(structure)
        ]
        self._codec: Any = codec

    @cached_property
    def _sizes(self) -> tuple[Any, int]:
        return generate_getsize_cdr(self.fields, self._codec)

    @cached_property
    def getsize_cdr(self) -> Callable[[int, object, Codec], int]:
        """Computes where a message ends that begins at a position."""
        return cast("Callable[[int, object, Codec], int]", self._sizes[0])

    @cached_property
    def size_cdr(self) -> int:
        """The size [bytes] that all messages have; 0 if it differs."""
        return self._sizes[1]

    @cached_property
    def serialize_cdr_le(self) -> Any:
        """Writes a message in little-endian order."""
        return generate_serialize_cdr(self.fields, self._codec, "le")

    @cached_property
    def deserialize_cdr_le(self) -> Any:
        """Reads a message in little-endian order."""
        return generate_deserialize_cdr(self.fields, self._codec, "le")

    @cached_property
    def deserialize_cdr_be(self) -> Any:
        """Reads a message in big-endian order."""
        return generate_deserialize_cdr(self.fields, self._codec, "be")


def _maker(message: type[Message]) -> Callable[..., Message]:
    """What makes a message of its members, in less time than its class takes, which small messages notice."""
    make = tuple.__new__
    return lambda *members: make(message, members)  # type: ignore[type-var]


def _described(type_: FieldType, place: str) -> Any:
    """A type in rosbags' words."""
    match type_:
        case Array(element, length):
            return (Nodetype.ARRAY, (_element(element, place), length))
        case Sequence(element, bound):
            return (Nodetype.SEQUENCE, (_element(element, place), bound))
        case Scalar() | Named():
            return _element(type_, place)


def _element(element: Element, place: str) -> Any:
    match element:
        case Named(name):
            return (Nodetype.NAME, name)
        case Scalar("wstring"):
            raise InvalidDefinition(
                f"{place}: `wstring` can be neither encoded nor decoded",
                help="middlewares of ROS 2 do not agree about its form on the wire; use `string`, which is UTF-8",
            )
        case Scalar(name, bound):
            return (Nodetype.BASE, ("uint8" if name in _OCTETS else name, bound))


def _wrong_header(payload: bytes) -> str:
    if len(payload) < _HEADER:
        return f"{len(payload)} bytes are no message; CDR begins with a header of {_HEADER} bytes"
    known = _FORMS.get(payload[1] // 2) if payload[0] == 0 else None
    begins = bytes(payload[:_HEADER]).hex(" ")
    form = f", which is {known}" if known else ""
    return f"the payload begins with {begins}{form}; plain CDR, which begins with 00 00 or 00 01, was expected"
