"""Checks and mapping of untrusted paths in bundles."""

from __future__ import annotations

import os.path
from pathlib import Path, PurePosixPath
from typing import Final

from seoro.bridges.executor.messages import MAX_PATH
from seoro.files.path_mapping import Locate, unchanged_path
from seoro.files.world_names import WorldName

MAX_NAME: Final = 255  # [bytes] of one part of a path, on most file systems
ROOT: Final = ""  # the root itself, as a path


class InvalidPath(Exception):
    """The path must not be followed."""


def is_world_name(world: str) -> bool:
    """Return whether a world is a name known to simulators, not a file."""
    name = WorldName.parse(world).world
    return "/" not in name and "." not in name


def check_path(path: str) -> PurePosixPath:
    """Check that a relative path stays within its folder, and convert it.

    Raises:
        InvalidPath: The path is empty, too long or absolute, or has invalid parts or characters.
    """
    if not path or len(path) > MAX_PATH:
        raise InvalidPath(f"a path with {len(path)} characters, expected 1 to {MAX_PATH}")
    parts = path.split("/")
    for part in parts:
        if part in ("", ".", ".."):
            raise InvalidPath(f"{path!r} is not a relative path without `.` and `..`")
        if "\\" in part or not part.isprintable() or len(part.encode("utf-8", "replace")) > MAX_NAME:
            raise InvalidPath(f"{path!r} has an invalid file name")
    return PurePosixPath(*parts)


def make_locator(root: str | None, folder: Path) -> Locate:
    """Make a function that maps absolute paths of the sender to files of the unpacked bundle.

    Args:
        root: Root of the bundle on the sender's machine, if known.
        folder: Folder of the unpacked bundle.
    """
    if root is None:
        return unchanged_path
    there = PurePosixPath(root)

    def locate(path: Path) -> Path:
        named = PurePosixPath(os.path.normpath(path))
        if not named.is_absolute() or not named.is_relative_to(there):
            return path
        try:
            found = folder / check_path(named.relative_to(there).as_posix())
        except InvalidPath:
            return path
        return found if found.exists() else path

    return locate
