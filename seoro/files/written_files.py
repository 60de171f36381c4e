"""Files that processes of this user write."""

from __future__ import annotations

import stat
from collections.abc import Collection
from pathlib import Path


def written_files(paths: Collection[Path]) -> set[Path]:
    """Return those of some files that a process of this user has open for writing; none without /proc."""
    wanted: dict[tuple[int, int], Path] = {}
    for path in paths:
        try:
            found = path.stat()
        except OSError:
            continue
        wanted[found.st_dev, found.st_ino] = path
    held: set[Path] = set()
    for process in _entries(Path("/proc")):
        if not process.name.isdecimal():
            continue
        for descriptor in _entries(process / "fd"):
            try:
                if not descriptor.lstat().st_mode & stat.S_IWUSR:  # open for reading only
                    continue
                found = descriptor.stat()
            except OSError:
                continue
            key = (found.st_dev, found.st_ino)
            if key in wanted:
                held.add(wanted[key])
        if len(held) == len(wanted):
            break
    return held


def _entries(folder: Path) -> list[Path]:
    try:
        return list(folder.iterdir())
    except OSError:
        return []
