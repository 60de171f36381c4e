"""Limits of messages, checked in the raw bytes before anything is decoded.

A payload of 20 MB that is one array of empty maps becomes 1.7 GB of Python objects. So the elements of a message
are counted first, without making any of them: the scan ends at the first header that claims more than is left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

MAX_MESSAGE: Final = 64 * 1024 * 1024  # [bytes] of the largest message that any verb has
MAX_REQUEST: Final = 16 * 1024 * 1024  # [bytes]; executors and nodes drop larger messages while they arrive
KIBIBYTE: Final = 1 << 10
MEBIBYTE: Final = 1 << 20


@dataclass(frozen=True)
class Limits:
    """Limits of a message.

    Attributes:
        size: [bytes].
        items: Elements: each number, text, array and map, and each key of a map.
        depth: Arrays and maps within one another.
    """

    size: int = 64 * KIBIBYTE
    items: int = 4096
    depth: int = 16


SMALL: Final = Limits()  # a request, unless its verb declares more
ANSWER: Final = Limits(16 * MEBIBYTE, 250_000)  # an answer or a stream: of thousands of entities at once
BYTES: Final = Limits(MAX_MESSAGE)  # few elements, one of which is large: a file, a picture, a snapshot


class LimitExceeded(ValueError):
    """A message has more than it may."""


def check_limits(payload: bytes, limits: Limits) -> int:
    """Check that a payload keeps its limits, and return how many elements it has.

    Invalid msgpack passes, with 0 elements: decoding finds it.

    Raises:
        LimitExceeded: It does not.
    """
    if len(payload) > limits.size:
        raise LimitExceeded(f"{len(payload)} bytes; at most {limits.size} are accepted")
    try:
        return _count(payload, limits)
    except IndexError:  # it ends in the middle of an element
        return 0


# By the first byte of an element: how many bytes a scalar has in all, or, of what has a length, 0.
_FIXED: Final = bytes(
    [1] * 0x80  # small numbers
    + [0] * 0x20  # small maps and arrays
    + [1 + length for length in range(0x20)]  # short texts
    + [1, 1, 1, 1]  # nil, the one that is unused, booleans
    + [0] * 6  # bytes and extensions with a length
    + [5, 9, 2, 3, 5, 9, 2, 3, 5, 9]  # numbers
    + [3, 4, 6, 10, 18]  # extensions
    + [0] * 7  # texts, arrays and maps with a length
    + [1] * 0x20  # small numbers
)
# Of those with a length: bytes of the length, and bytes that follow it beside the content.
_CONTENT: Final = {
    0xC4: (1, 0), 0xC5: (2, 0), 0xC6: (4, 0), 0xC7: (1, 1), 0xC8: (2, 1), 0xC9: (4, 1), 0xD9: (1, 0), 0xDA: (2, 0),
    0xDB: (4, 0),
}  # fmt: skip
_CONTAINER: Final = {0xDC: (2, 1), 0xDD: (4, 1), 0xDE: (2, 2), 0xDF: (4, 2)}  # bytes of the length; per element


def _count(data: bytes, limits: Limits) -> int:
    """Count the elements, and end at the first header that claims too many.

    Raises:
        LimitExceeded: There are too many of them, or they are too deep within one another.
        IndexError: The bytes end too early.
    """
    fixed, at = _FIXED, 0
    open_: list[int] = []  # elements that follow in the containers around this one
    here, left = 1, limits.items - 1  # elements that follow in this container; what all others may have
    while True:
        while not here:
            if not open_:
                return limits.items - left
            here = open_.pop()
        here -= 1
        head = data[at]
        if size := fixed[head]:
            at += size
            continue
        if head in _CONTENT:
            width, beside = _CONTENT[head]
            at += 1 + width + beside + int.from_bytes(data[at + 1 : at + 1 + width])
            continue
        if head < 0xA0:
            width, count = 0, (head & 0x0F) * (1 if head >= 0x90 else 2)
        else:
            width, each = _CONTAINER[head]
            count = each * int.from_bytes(data[at + 1 : at + 1 + width])
        at += 1 + width
        left -= count
        if left < 0:
            raise LimitExceeded(f"more than {limits.items} elements")
        if len(open_) >= limits.depth:
            raise LimitExceeded(f"more than {limits.depth} arrays and maps within one another")
        open_.append(here)
        here = count
