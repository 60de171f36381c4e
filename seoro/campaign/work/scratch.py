"""Folder for the files of the present run of a worker: kept with the run, or used again for the next one."""

from __future__ import annotations

import os
import shutil
from pathlib import Path


class Scratch:
    """Folder of a worker; close it at the end.

    Args:
        path: The folder. It exists while the worker makes runs, since making one for each run costs as much as a
            tenth of a short run.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def empty(self) -> Path:
        """Return the folder, without files of an earlier run.

        Raises:
            OSError: It cannot be written.
        """
        try:
            with os.scandir(self._path) as entries:
                if next(entries, None) is None:
                    return self._path
            shutil.rmtree(self._path)
        except FileNotFoundError:
            pass
        self._path.mkdir(parents=True)
        return self._path

    def keep_as(self, folder: Path) -> None:
        """Rename the folder, and replace another one there."""
        shutil.rmtree(folder, ignore_errors=True)
        self._path.replace(folder)

    def close(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self._path, ignore_errors=True)
