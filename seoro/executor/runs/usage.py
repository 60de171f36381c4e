"""Resource usage of runs: memory, processes, files and trace, with their limits.

A run with too much memory or too many processes is killed, since it may have no resources left for a clean stop. A
run that writes too much is stopped: it cleans up, and ends as an error.
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

from seoro.executor.limits import MEBIBYTE, Limits, limit_reached
from seoro.executor.runs.memory import PERIOD, Census, used_by
from seoro.executor.storage.blobs import in_mebibytes
from seoro.executor.storage.run_folder import RunFolder, open_left

SMALLEST: Final = 4096  # [bytes] smallest size of a file on the disk
TO_END: Final = MEBIBYTE  # [bytes] of trace beyond the limit, to record the end of the run
LONGEST_LINE: Final = MEBIBYTE  # [bytes] searched for the end of a line when a file is cut
OVERRUN: Final = 1.25  # times its limit: a run that writes more is killed

_census: Final = Census()


@dataclass(frozen=True)
class Excess:
    """An exceeded limit: the reason for users, and whether the run is killed."""

    reason: str
    is_to_kill: bool


@dataclass(frozen=True)
class Usage:
    """Usage of a run: memory [MiB], number of processes, and sizes of its output and log [bytes]."""

    memory: int
    processes: int
    output: int
    log: int

    def excess(self, limits: Limits) -> Excess | None:
        """Return the exceeded limit, or None."""
        if limits.memory is not None and self.memory > limits.memory:
            what = f"the run used {self.memory} MiB of memory, more than {limits.memory} MiB"
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
        process: First process of the run.
        folder: Folder of its files; None if they do not count.
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
    """Wait until a run exceeds a limit.

    Args:
        process: First process of the run.
        limits: Limits of its client.
        folder: Folder of its files; None if they do not count.
        note: Called with each measurement.
    """
    while True:
        await asyncio.sleep(PERIOD)
        usage = await asyncio.to_thread(usage_of, process, folder)
        if note is not None:
            note(usage)
        if (excess := usage.excess(limits)) is not None:
            return excess


def size_of_files(folder: Path) -> int:
    """Return the disk space of all files in and below a folder [bytes]."""
    total = 0
    for place, folders, files in os.walk(folder):
        total += SMALLEST * len(folders)
        total += sum(_size(Path(place, name)) for name in files)
    return total


def _size(path: Path) -> int:
    try:
        return max(SMALLEST, 512 * path.lstat().st_blocks)
    except OSError:  # removed
        return 0


class TraceFile:
    """File of a trace, which grows by whole lines.

    Args:
        file: The file.
        limit: Size limit [bytes].
        reserve: Free space of the disk [bytes].
    """

    def __init__(self, file: FileIO, limit: int, reserve: int) -> None:
        self._file = file
        self.limit = limit
        self._reserve = reserve
        self._size = os.fstat(file.fileno()).st_size
        self._is_cut = False

    def is_full_with(self, lines: bytes) -> bool:
        """Whether the trace would exceed its limit."""
        return self._size + len(lines) > self.limit

    def lacks_disk(self, lines: bytes) -> bool:
        """Whether the disk would have too little free space."""
        return shutil.disk_usage(self._file.fileno()).free - len(lines) < self._reserve

    def write(self, lines: bytes) -> bytes:
        """Append lines up to the limits; returns the written ones.

        A little space beyond the limits is left for the end of the run. After the first line that does not fit,
        nothing is written any more: a trace has no gaps.

        Raises:
            OSError: Writing failed.
        """
        room = self.limit + TO_END - self._size
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
    """Truncate a file after the last whole line within a size [bytes]."""
    try:
        with open_left(path, path.parent, writes=True) as file:
            if file.seek(0, os.SEEK_END) > size:
                start = file.seek(max(0, size - LONGEST_LINE))
                file.truncate(start + file.read(size - start).rfind(b"\n") + 1)
    except FileNotFoundError:
        return
