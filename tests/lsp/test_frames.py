"""Invalid frames: the server answers each with an error, and reads the next ones."""

from __future__ import annotations

import io
from typing import BinaryIO, cast

import pytest

from seoro.lsp.frames import MAX_BODY, Frames

GOOD = b"Content-Length: 4\r\n\r\ntrue"
BAD = {
    "too long": (b"Content-Length: 99999999999999\r\n\r\n{}", "99999999999999 bytes"),
    "over the limit": (b"Content-Length: %d\r\n\r\n%b" % (MAX_BODY + 1, b" " * 200_000), "the limit is"),
    "no number": (b"Content-Length: many\r\n\r\n{}", "not a number: `many`"),
    "negative": (b"Content-Length: -3\r\n\r\n{}", "not a number: `-3`"),
    "no length": (b"Content-Type: text\r\n\r\n{}", "without a `Content-Length`"),
    "no header": (b'\r\n\r\n{"jsonrpc": "2.0"}\r\n\r\n', "without a `Content-Length`"),
    "many headers": (b"X: y\r\n" * 100, "without a `Content-Length`"),
}


def bodies(data: bytes) -> tuple[list[bytes], list[str]]:
    """Return the bodies that the library reads, and the reasons of skipped frames."""
    refused: list[str] = []
    frames = Frames(cast(BinaryIO, io.BytesIO(data)), refused.append)
    found = []
    while header := frames.readline():
        assert frames.readline() == b"\r\n"
        found.append(frames.read(int(header.split(b":")[1])))
    return found, refused


@pytest.mark.parametrize("name", BAD)
def test_an_invalid_frame_is_refused_once_and_later_frames_are_read(name: str) -> None:
    frame, reason = BAD[name]
    found, refused = bodies(GOOD + frame + GOOD + GOOD)
    assert found == [b"true"] * 3
    assert len(refused) == 1 and reason in refused[0]


def test_headers_are_read_in_any_case_and_order() -> None:
    data = b"content-type: x\r\ncontent-length:4\r\n\r\ntrue" + b"Content-Length: 2\nX: y\n\n{}"
    assert bodies(data) == ([b"true", b"{}"], [])


def test_a_header_across_two_skipped_blocks_is_found() -> None:
    for length in range(2**16 - 30, 2**16 + 2):
        found, refused = bodies(b"\r\n" + b"x" * length + GOOD)
        assert found == [b"true"], length
        assert len(refused) == 1
