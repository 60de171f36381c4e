"""Files of lines, appended with one `write` each, so that a killed writer leaves at most one torn line."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from seoro.files.inputs import Kind, open_input

_READ: Final = 1 << 20  # [bytes] of a block
_BLOCK: Final = 1 << 16  # [bytes] read at a time from the end


class Appender:
    """Appends lines to a file; close it at the end.

    Args:
        path: The file; created if missing. A torn last line, left by a killed writer, is cut off.

    Raises:
        OSError: The file cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        cut_torn_line(path)
        self._descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o644)

    def append(self, lines: str) -> None:
        """Append whole lines.

        Raises:
            OSError: The file cannot be written, for instance because the disk is full; no part of a line stays.
        """
        data = lines.encode("utf-8", "backslashreplace")
        before = os.lseek(self._descriptor, 0, os.SEEK_END)
        try:
            while data:
                data = data[os.write(self._descriptor, data) :]
        except OSError:
            os.ftruncate(self._descriptor, before)
            raise

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)


def read_lines(path: Path) -> Iterator[bytes]:
    """Yield the whole lines of a file; none if it is missing.

    Raises:
        OSError: It cannot be read.
    """
    for lines in read_blocks(path):
        yield from lines


def read_blocks(path: Path, start: int = 0) -> Iterator[list[bytes]]:
    """Yield the whole lines of a file in blocks of about a megabyte; none if it is missing.

    Args:
        path: The file.
        start: Position of the first line [bytes].

    Raises:
        OSError: It cannot be read.
    """
    try:
        file = open_input(path, Kind.CAMPAIGN)
    except FileNotFoundError:
        return
    with file:
        if start:
            file.seek(start)
        while lines := file.readlines(_READ):
            is_torn = not lines[-1].endswith(b"\n")
            if is_torn:
                del lines[-1]
            if lines:
                yield lines
            if is_torn:  # the file may grow meanwhile
                return


def cut_torn_line(path: Path) -> None:
    """Remove a last line without an end.

    Raises:
        OSError: The file cannot be read or written.
    """
    try:
        file = path.open("rb+")
    except FileNotFoundError:
        return
    with file:
        end = size = file.seek(0, os.SEEK_END)
        while end > 0:
            start = max(0, end - _BLOCK)
            file.seek(start)
            found = file.read(end - start).rfind(b"\n")
            if found >= 0:
                end = start + found + 1
                break
            end = start
        if end < size:
            file.truncate(end)
