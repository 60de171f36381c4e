"""Limits of messages, checked in the raw bytes before anything is decoded.

An array of empty maps with 20 MB becomes 1.7 GB of Python objects. So the elements of a message are counted first,
without decoding them. The scan ends at the first header that exceeds the limit.
"""

from __future__ import annotations

from typing import Final

from seoro.deferred import dataclass

MAX_MESSAGE: Final = 64 * 1024 * 1024  # [bytes] of the largest message of any verb
MAX_REQUEST: Final = 16 * 1024 * 1024  # [bytes]; executors and nodes drop larger messages while they arrive
KIBIBYTE: Final = 1 << 10
MEBIBYTE: Final = 1 << 20


@dataclass(frozen=True)
class Limits:
    """Limits of a message.

    Attributes:
        size: Maximum size [bytes].
        items: Maximum number of elements: each number, text, array and map, and each key of a map.
        depth: Maximum number of nested arrays and maps.
    """

    size: int = 64 * KIBIBYTE
    items: int = 4096
    depth: int = 16


SMALL: Final = Limits()  # requests, unless their verb declares more
ANSWER: Final = Limits(16 * MEBIBYTE, 250_000)  # replies and streams: thousands of entities
BYTES: Final = Limits(MAX_MESSAGE)  # few elements, some of them large: files, pictures, snapshots


class LimitExceeded(ValueError):
    """A message exceeds its limits."""


def check_limits(payload: bytes, limits: Limits) -> int:
    """Check the limits of a payload, and return its number of elements.

    Invalid msgpack passes with 0 elements: decoding detects it.

    Raises:
        LimitExceeded: The payload exceeds a limit.
    """
    if len(payload) > limits.size:
        raise LimitExceeded(f"{len(payload)} bytes; expected at most {limits.size}")
    try:
        return _count(payload, limits)
    except IndexError:  # the payload ends within an element
        return 0


# Size of a scalar by its first byte [bytes]; 0 for elements with a length.
_FIXED: Final = bytes(
    [1] * 0x80  # small numbers
    + [0] * 0x20  # small maps and arrays
    + [1 + length for length in range(0x20)]  # short texts
    + [1, 1, 1, 1]  # nil, the unused code, booleans
    + [0] * 6  # bytes and extensions with a length
    + [5, 9, 2, 3, 5, 9, 2, 3, 5, 9]  # numbers
    + [3, 4, 6, 10, 18]  # extensions
    + [0] * 7  # texts, arrays and maps with a length
    + [1] * 0x20  # small numbers
)
# Scalars with a length: bytes of the length, and further bytes besides the content.
_CONTENT: Final = {
    0xC4: (1, 0), 0xC5: (2, 0), 0xC6: (4, 0), 0xC7: (1, 1), 0xC8: (2, 1), 0xC9: (4, 1), 0xD9: (1, 0), 0xDA: (2, 0),
    0xDB: (4, 0),
}  # fmt: skip
_CONTAINER: Final = {0xDC: (2, 1), 0xDD: (4, 1), 0xDE: (2, 2), 0xDF: (4, 2)}  # bytes of the length; per element


def _count(data: bytes, limits: Limits) -> int:
    """Count the elements up to the first header that exceeds the limits.

    Raises:
        LimitExceeded: Too many elements, or too many nested arrays and maps.
        IndexError: The bytes end too early.
    """
    fixed, at = _FIXED, 0
    open_: list[int] = []  # remaining elements of each outer container
    here, left = 1, limits.items - 1  # remaining elements of this container, and of the limit
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
            raise LimitExceeded(f"more than {limits.depth} nested arrays and maps")
        open_.append(here)
        here = count
