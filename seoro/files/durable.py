"""Blocking `fsync` of files and folders, so that they survive a loss of power."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

AT_ONCE: Final = 8  # simultaneous syncs, which file systems write together


def sync_file(path: Path) -> None:
    """Sync the content of a file to the disk.

    Raises:
        OSError: The sync failed.
    """
    _sync(path, os.O_RDONLY | os.O_NOFOLLOW)


def sync_folder(path: Path) -> None:
    """Sync the entries of a folder to the disk, without the contents of files.

    Raises:
        OSError: The sync failed.
    """
    _sync(path, os.O_RDONLY | os.O_DIRECTORY)


def sync_tree(path: Path) -> None:
    """Sync a folder to the disk, with all files and folders below it; links are not followed.

    Raises:
        OSError: The sync failed.
    """
    files: dict[int, Path] = {}  # by inode: a file with several names is synced once
    folders: list[Path] = []
    for place, _, _ in os.walk(path):
        folders.append(Path(place))
        with os.scandir(place) as entries:
            files |= {entry.inode(): Path(entry) for entry in entries if entry.is_file(follow_symlinks=False)}
    if len(files) <= 1:
        for file in files.values():
            sync_file(file)
    else:
        with ThreadPoolExecutor(min(AT_ONCE, len(files)), "sync") as threads:
            for _ in threads.map(sync_file, files.values()):
                pass
    for folder in reversed(folders):
        sync_folder(folder)


def _sync(path: Path, flags: int) -> None:
    descriptor = os.open(path, flags | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
