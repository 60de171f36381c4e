"""Files that runs have left, or are writing: links in their place must lead nowhere else."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import IO


def open_left(path: Path, folder: Path, *, writes: bool = False) -> IO[bytes]:
    """Open a regular file in or below a folder that a run may write.

    Args:
        path: The file. What it is may change at any time, so it is looked at when it is open.
        folder: The folder.
        writes: Whether it is opened for writing, too.

    Raises:
        OSError: There is none, or it is something else, or a link leads out of the folder.
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
