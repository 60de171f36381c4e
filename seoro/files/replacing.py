"""Writing of files that readers see as a whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Provide the path of a partial file beside a file, which it replaces if the block succeeds.

    Args:
        path: The file.

    Raises:
        OSError: The file cannot be replaced; the partial file is removed.
    """
    partial = path.with_name(f".{path.name}.part")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
