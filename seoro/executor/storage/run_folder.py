"""Folder of a run: its paths, and safe access to the files that the run writes."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import IO, Final

from seoro.files.durable import sync_file, sync_folder, sync_tree


class RunFolder:
    """Paths of the files of a run.

    Attributes:
        path: Folder of the run.
        files: Folder of the bundle.
        output: Folder of output files.
        trace: File of the trace.
        home: Home folder of its programs during the run.
        log: File of the printed output, among the output files.
    """

    def __init__(self, path: Path) -> None:
        self.path: Final = path
        self.files: Final = path / "files"
        self.output: Final = path / "output"
        self.trace: Final = path / "trace.jsonl"
        self.home: Final = path / "home"
        self.log: Final = self.output / "log.txt"

    def sync(self) -> None:
        """Force the trace and the output files to the disk; blocks.

        Raises:
            OSError: Writing to the disk failed.
        """
        if self.output.exists():
            sync_tree(self.output)
        if self.trace.exists():
            sync_file(self.trace)
        sync_folder(self.path)


def open_left(path: Path, folder: Path, *, writes: bool = False) -> IO[bytes]:
    """Open a regular file in or below a folder that a run may write.

    Args:
        path: The file. The run may replace it at any time, so it is checked after opening.
        folder: The folder.
        writes: Whether to open it for writing, too.

    Raises:
        OSError: The file is missing, not a regular file, or outside the folder.
    """
    descriptor = os.open(path, (os.O_RDWR if writes else os.O_RDONLY) | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        place = Path(f"/proc/self/fd/{descriptor}").readlink()
        if not stat.S_ISREG(os.fstat(descriptor).st_mode) or not place.is_relative_to(folder.resolve()):
            raise FileNotFoundError(f"{path} is not a file of the run")
        return os.fdopen(descriptor, "r+b" if writes else "rb")
    except BaseException:
        os.close(descriptor)
        raise
