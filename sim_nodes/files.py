"""Files that a world file names, such as models, floor plans and declarations of robots."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

MAX_TEXT = 1_000_000  # [bytes]


class FileError(Exception):
    """A file that a world file names cannot be read, or is wrong."""


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        FileError: It cannot be read, or is too large.
    """
    try:
        if path.stat().st_size > MAX_TEXT:
            raise FileError(f"{path} is larger than {MAX_TEXT} bytes")
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"cannot read {path}: {error}") from error


def problems(error: ValidationError) -> str:
    """Everything that is wrong with what a file says, with the place of each."""
    places = ((".".join(map(str, item["loc"])) or "the file", item["msg"]) for item in error.errors())
    return "; ".join(f"{place}: {message}" for place, message in places)
