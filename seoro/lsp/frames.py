"""Validating reader for the frames of the protocol.

The protocol library trusts every header: it waits forever for a body whose length is missing, and allocates any
claimed length. This reader skips invalid frames, and resumes at the next header.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from typing import BinaryIO, Final

MAX_BODY: Final = 64 * 2**20  # bytes of a message: texts of files are far shorter
_MAX_LINE: Final = 2**16  # bytes per read while searching for the next header
_MAX_HEADERS: Final = 32  # lines before a body
_LENGTH: Final = re.compile(rb"Content-Length:[ \t]*([^\r\n]*)\r?\n\Z", re.IGNORECASE)
_OVERLAP: Final = 64  # bytes kept between reads, since a header may begin in them


class Frames(io.RawIOBase):
    """A stream of valid frames.

    Args:
        stream: Source of the frames.
        refuse: Called with the reason when a frame is skipped.
    """

    def __init__(self, stream: BinaryIO, refuse: Callable[[str], None]) -> None:
        super().__init__()
        self._stream = stream
        self._refuse = refuse
        self._lines: list[bytes] = []  # of a valid header
        self._is_lost = False  # a frame was skipped, and the next header is being searched

    def readable(self) -> bool:
        """Return True, as for any readable stream."""
        return True

    def readline(self, size: int | None = -1, /) -> bytes:
        """Return the next line of a valid header; empty at the end of the stream."""
        if not self._lines:
            length = self._next_length()
            if length is None:
                return b""
            self._lines = [b"Content-Length: %d\r\n" % length, b"\r\n"]
        return self._lines.pop(0)

    def read(self, size: int = -1, /) -> bytes:
        """Return the body of `size` bytes; shorter at the end of the stream."""
        parts = []
        while size > 0 and (part := self._stream.read(min(size, 2**20))):
            parts.append(part)
            size -= len(part)
        return b"".join(parts)

    def _next_length(self) -> int | None:
        """Read the next valid header and return its length; None at the end of the stream."""
        while True:
            length: bytes | None = None
            kept = b""
            for _ in range(_MAX_HEADERS):
                line = self._stream.readline(_MAX_LINE)
                if not line:
                    return None
                found = _LENGTH.search(kept + line)
                kept = b"" if line.endswith(b"\n") else line[-_OVERLAP:]
                if found is not None:
                    length = found[1].strip()
                    self._is_lost = False
                elif not line.strip() and not self._is_lost:
                    break
            number = self._checked(length)
            if number is not None:
                return number

    def _checked(self, length: bytes | None) -> int | None:
        """Return the length in a header; None if it is invalid, reported once until the next valid one."""
        if self._is_lost:
            return None
        shown = (length or b"")[:40].decode("ascii", "replace")
        if length is None:
            reason = "a message without a `Content-Length`"
        elif not length.isdigit():
            reason = f"a message whose `Content-Length` is not a number: `{shown}`"
        elif len(length) > len(str(MAX_BODY)) or int(length) > MAX_BODY:
            reason = f"a message of {shown} bytes; the limit is {MAX_BODY}"
        else:
            return int(length)
        self._is_lost = True
        self._refuse(f"skipped {reason}")
        return None
