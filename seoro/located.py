"""Where files are that are named by absolute paths: elsewhere, if they were sent from another machine."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

Locate: TypeAlias = Callable[[Path], Path]  # gives the place of a path, which is itself unless it was sent


def as_named(path: Path) -> Path:
    """The place of a file on the machine on which it was named."""
    return path
