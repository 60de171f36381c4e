"""Limits of what a run uses: memory, processes, files, and its trace.

A run with too much memory or too many processes is killed, since it may have nothing left with which to stop in
order. One that writes too much is given up: it cleans up, and ends as an error.
"""

from __future__ import annotations

import asyncio
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import Final

from seoro.executor.blobs import in_mebibytes
from seoro.executor.left import open_left
from seoro.executor.limits import MEBIBYTE, Limits, limit_reached
from seoro.executor.memory import PERIOD, Census, used_by
from seoro.executor.store import RunFolder

SMALLEST: Final = 4096  # [bytes] of disk that a file takes at least
TO_END: Final = MEBIBYTE  # [bytes] of trace in which a run that has reached a limit may record its end
LONGEST_LINE: Final = MEBIBYTE  # [bytes] that is looked for when a file is cut
OVERRUN: Final = 1.25  # of its limit, a run that does not stop writing is killed

_census: Final = Census()


@dataclass(frozen=True)
class Excess:
    """A limit that a run has reached: why it ends, and whether it is killed."""

    reason: str
    is_to_kill: bool


@dataclass(frozen=True)
class Usage:
    """Usage of a run at a moment: memory [MiB], processes, and sizes of its output and of its log [bytes]."""

    memory: int
    processes: int
    output: int
    log: int

    def excess(self, limits: Limits) -> Excess | None:
        """The limit that is exceeded, if one is."""
        if limits.memory is not None and self.memory > limits.memory:
            what = f"the run took {self.memory} MiB of memory, more than {limits.memory} MiB"
            return Excess(limit_reached(what, "memory"), is_to_kill=True)
        if limits.processes is not None and self.processes > limits.processes:
            what = f"the run had {self.processes} processes, more than {limits.processes}"
            return Excess(limit_reached(what, "processes"), is_to_kill=True)
        for name, size, limit in (("log", self.log, limits.log), ("output", self.output, limits.output)):
            if limit is not None and size > limit * MEBIBYTE:
                what = f"the {name} of the run has {in_mebibytes(size)}, more than {limit} MiB"
                return Excess(limit_reached(what, name), is_to_kill=size > OVERRUN * limit * MEBIBYTE)
        return None


def usage_of(process: int, folder: RunFolder | None) -> Usage:
    """Measure the usage of a run.

    Args:
        process: The first of its processes.
        folder: Of its files, if they count.
    """
    family = _census.family(process)
    if folder is None:
        return Usage(used_by(family), len(family), 0, 0)
    log = _size(folder.log)
    output = size_of_files(folder.output) + size_of_files(folder.home)
    return Usage(used_by(family), len(family), max(0, output - log), log)


async def exceeds(
    process: int, limits: Limits, folder: RunFolder | None = None, note: Callable[[Usage], object] | None = None
) -> Excess:
    """Wait until a run has more than it may have.

    Args:
        process: The first of its processes.
        limits: Of who has submitted it.
        folder: Of its files, if they count.
        note: Called with each look.
    """
    while True:
        await asyncio.sleep(PERIOD)
        usage = await asyncio.to_thread(usage_of, process, folder)
        if note is not None:
            note(usage)
        if (excess := usage.excess(limits)) is not None:
            return excess


def size_of_files(folder: Path) -> int:
    """Bytes of disk that the files in and below a folder take."""
    total = 0
    for place, folders, files in os.walk(folder):
        total += SMALLEST * len(folders)
        total += sum(_size(Path(place, name)) for name in files)
    return total


def _size(path: Path) -> int:
    try:
        return max(SMALLEST, 512 * path.lstat().st_blocks)
    except OSError:  # it is gone
        return 0


class TraceFile:
    """The trace of a run, which grows by whole lines.

    Args:
        file: Where it is written.
        limit: Its size at most [bytes].
        reserve: Of its disk, what stays free [bytes].
    """

    def __init__(self, file: FileIO, limit: int, reserve: int) -> None:
        self._file = file
        self._limit = limit
        self._reserve = reserve
        self._size = os.fstat(file.fileno()).st_size
        self._is_cut = False

    def is_full_with(self, lines: bytes) -> bool:
        """Whether it would exceed its limit."""
        return self._size + len(lines) > self._limit

    def lacks_disk(self, lines: bytes) -> bool:
        """Whether the disk would have less left than it must."""
        return shutil.disk_usage(self._file.fileno()).free - len(lines) < self._reserve

    def write(self, lines: bytes) -> bytes:
        """Append lines, as far as there is room; returns those that were written.

        Beyond the limits there is a little room, so that a run can record its end. After the first line for which
        there is none, nothing is written any more: a trace has no gaps.

        Raises:
            OSError: Something could not be written.
        """
        room = self._limit + TO_END - self._size
        if self.lacks_disk(lines):
            free = shutil.disk_usage(self._file.fileno()).free
            room = min(room, free - self._reserve // 2)
        if not self._is_cut and len(lines) > room:
            self._is_cut = True
            lines = lines[: lines.rfind(b"\n", 0, max(0, room)) + 1]
        elif self._is_cut:
            return b""
        write_all(self._file, lines)
        self._size += len(lines)
        return lines


def write_all(file: FileIO, data: bytes) -> None:
    """Write all bytes; readers skip a line that is cut off."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def cut(path: Path, size: int) -> None:
    """Cut a file after the last whole line that ends within a size [bytes]."""
    try:
        with open_left(path, path.parent, writes=True) as file:
            if file.seek(0, os.SEEK_END) > size:
                start = file.seek(max(0, size - LONGEST_LINE))
                file.truncate(start + file.read(size - start).rfind(b"\n") + 1)
    except FileNotFoundError:
        return
