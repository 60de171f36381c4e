"""Values for all structures, drawn with a seed."""

import random
import struct
from typing import Any

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.interfaces.definitions import (
    INTEGERS,
    SUFFIXES,
    Array,
    Element,
    FieldType,
    Named,
    Scalar,
    Sequence,
)

LETTERS = "abcdefghij klmnop äöü€😀"


def structures(store: TypeStore) -> list[str]:
    """Return the names of all structures on the wire except those with wide strings."""
    sent = [
        f"{interface}{suffix}"
        for interface in store.names()
        for suffix in SUFFIXES[interface.split("/")[1]]
        if suffix.endswith(("_Request", "_Response", "_Message")) or "/msg/" in interface
    ]
    return [name for name in sent if name != "example_interfaces/msg/WString"]


def sample(store: TypeStore, name: str, draw: random.Random) -> dict[str, Any]:
    """Return a random value of a structure with all members."""
    return {field.name: _value(store, field.type, draw) for field in store.structure(name).fields}


def _value(store: TypeStore, type_: FieldType, draw: random.Random) -> Any:
    match type_:
        case Array(element, length):
            return [_element(store, element, draw) for _ in range(length)]
        case Sequence(element, bound):
            return [_element(store, element, draw) for _ in range(draw.randint(0, min(bound or 3, 3)))]
        case Scalar() | Named():
            return _element(store, type_, draw)


def _element(store: TypeStore, element: Element, draw: random.Random) -> Any:
    match element:
        case Named(name):
            return sample(store, name, draw)
        case Scalar("bool"):
            return draw.random() < 0.5
        case Scalar("string", bound):
            return "".join(draw.choices(LETTERS, k=draw.randint(0, 9)))[: bound // 4 or None]
        case Scalar("float32"):
            (value,) = struct.unpack("<f", struct.pack("<f", draw.gauss(0, 1e3)))
            return value
        case Scalar("float64"):
            return draw.gauss(0, 1e6)
        case Scalar("char"):
            return draw.randint(0, 127)  # mcap-ros2-support takes it for a signed number
        case Scalar(name):
            return draw.randint(*INTEGERS[name])
