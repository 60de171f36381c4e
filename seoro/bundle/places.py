"""Paths that come from elsewhere: which of them may name something in a folder of ours, and which are none."""

from __future__ import annotations

import os.path
from pathlib import Path, PurePosixPath
from typing import Final

from seoro.bridges.executor.messages import MAX_PATH
from seoro.located import Locate, as_named

MAX_NAME: Final = 255  # [bytes] of one part of a path, on most file systems
ROOT: Final = ""  # the root itself, as a path


class InvalidPlace(Exception):
    """A path that must not be followed."""


def is_world_name(world: str) -> bool:
    """Whether a world is known to simulators by a name, which no file has."""
    return "/" not in world and "." not in world


def check_place(path: str) -> PurePosixPath:
    """A path relative to a folder, which cannot lead out of it.

    Raises:
        InvalidPlace: It is empty or too long, absolute, has parts such as `..`, or characters that no name should.
    """
    if not path or len(path) > MAX_PATH:
        raise InvalidPlace(f"a path has 1 to {MAX_PATH} characters, not {len(path)}")
    parts = path.split("/")
    for part in parts:
        if part in ("", ".", ".."):
            raise InvalidPlace(f"{path!r} is not a plain path below a folder")
        if "\\" in part or not part.isprintable() or len(part.encode("utf-8", "replace")) > MAX_NAME:
            raise InvalidPlace(f"{path!r} has a part that cannot be the name of a file here")
    return PurePosixPath(*parts)


def locating(root: str | None, folder: Path) -> Locate:
    """Finds what is in a bundle by the absolute path that it had where the bundle was made.

    Args:
        root: What the root of the bundle is called there; None if that is not known.
        folder: Where the bundle lies here.
    """
    if root is None:
        return as_named
    there = PurePosixPath(root)

    def locate(path: Path) -> Path:
        named = PurePosixPath(os.path.normpath(path))
        if not named.is_absolute() or not named.is_relative_to(there):
            return path
        try:
            found = folder / check_place(named.relative_to(there).as_posix())
        except InvalidPlace:
            return path
        return found if found.exists() else path

    return locate
