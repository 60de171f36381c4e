"""Paths that come from elsewhere: which of them may name something in a folder of ours, and which are none."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Final

from seoro.bridges.executor.messages import MAX_PATH

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
