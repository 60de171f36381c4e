"""Links to the folders of executors of this user, for pages that show their pictures."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

LINKS: Final = ".executors"  # in the folder for persistent state


@contextmanager
def linked(folder: Path, state: Path) -> Iterator[None]:
    """Have a link to the folder of an executor while the block lasts.

    A link of a killed executor does no harm: the next executor replaces it, or removes it if its folder is gone.
    Where links cannot be made, pages show no pictures.

    Args:
        folder: The folder.
        state: Folder for persistent state of this user.
    """
    links = state / LINKS
    link = links / hashlib.sha256(str(folder.resolve()).encode()).hexdigest()[:16]
    with suppress(OSError):
        links.mkdir(mode=0o700, parents=True, exist_ok=True)
        for each in links.iterdir():
            if each == link or not each.exists():
                each.unlink(missing_ok=True)
        link.symlink_to(folder.resolve(), target_is_directory=True)
    try:
        yield
    finally:
        with suppress(OSError):
            link.unlink(missing_ok=True)
