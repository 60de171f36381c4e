"""Bounded walk through the folders of the site."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

MOST_FOLDERS: Final = 20_000
_DEEPEST: Final = 12  # levels below a folder of the site
_SKIPPED: Final = frozenset({"node_modules", "__pycache__", "site-packages"})


def walk(roots: Sequence[Path]) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Yield folders with the names of their folders and files, at most `MOST_FOLDERS`.

    Hidden folders and links are skipped, and folders that cannot be read. The receiver may remove names of folders
    from the list to skip them.
    """
    seen: set[str] = set()
    for root in roots:
        base = len(root.parts)
        for place, folders, files in os.walk(root):
            path = Path(place)
            if place in seen or len(seen) >= MOST_FOLDERS:
                folders.clear()
                continue
            seen.add(place)
            is_deepest = len(path.parts) - base >= _DEEPEST
            folders[:] = [] if is_deepest else sorted(filter(_is_visited, folders))
            yield path, folders, files


def _is_visited(name: str) -> bool:
    return not name.startswith(".") and name not in _SKIPPED
