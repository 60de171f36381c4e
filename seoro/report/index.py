"""Data of finished runs on disk, so that pages of long runs open without reading their traces again."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from seoro.files.cache import cache_folder, digest_of, read_cached, stamps_of, write_cached
from seoro.files.inputs import resolved
from seoro.report.blocks import Block
from seoro.report.folder import RESULTS

_ROOT: Final = Path(__file__).parent.parent
MOST_FILES: Final = 50  # the oldest are removed; each has 16 MiB at most
SMALLEST: Final = 1 << 20  # [bytes] of a trace; shorter ones are read quickly
_MAKERS: Final = tuple(path for name in ("report", "traces") for path in sorted((_ROOT / name).glob("*.py")))
LEVEL: Final = 5  # of compression
_PIECE: Final = 1 << 20  # [bytes]
_SUFFIX: Final = ".run"


@dataclass(frozen=True)
class Index:
    """Data of a finished run.

    Args:
        status: Status of the run.
        frame: First frame of a page, compressed.
        blocks: Blocks of records, which are in the trace.
    """

    status: str
    frame: bytes
    blocks: Sequence[Block]

    def write_frame(self, write: Callable[[bytes], object]) -> None:
        """Write the first frame of a page in pieces."""
        decompressor = zlib.decompressobj()
        data = self.frame
        while piece := decompressor.decompress(data, _PIECE):
            write(piece)
            data = decompressor.unconsumed_tail


def place_of(trace: Path, folder: Path | None) -> Path | None:
    """Return the file in the cache for a trace as it is now; None if it should not be cached.

    Args:
        trace: The trace. Any change of its size or time leads to another file.
        folder: Folder with other results, which count, too; None for none.
    """
    cache = cache_folder("runs")
    if cache is None:
        return None
    results = [] if folder is None else [path for path in (folder / name for name in RESULTS) if path.is_file()]
    try:
        if trace.stat().st_size < SMALLEST:
            return None
        stamps = stamps_of([trace, *results, *_MAKERS])  # data of another version would not fit the pages
        names = "\n".join(str(resolved(path)) for path in (trace, *results))
        return cache / (digest_of(f"{names}\n{stamps}") + _SUFFIX)
    except (OSError, UnicodeEncodeError):
        return None


def load(place: Path) -> Index | None:
    """Read an index; None if it is missing or damaged."""
    data = read_cached(place)
    if data is None:
        return None
    with suppress(OSError):
        os.utime(place)  # the oldest ones are removed
    return _decoded(data)


def store(place: Path, index: Index) -> None:
    """Write an index, and remove the oldest ones. Errors are ignored: the trace can be read again."""
    with suppress(OSError):
        write_cached(place, _encoded(index))
        files = sorted(place.parent.glob(f"*{_SUFFIX}"), key=lambda path: path.stat().st_mtime, reverse=True)
        for path in files[MOST_FILES:]:
            path.unlink()


def _encoded(index: Index) -> bytes:
    blocks = [[block.head.decode(), *block.ranges] for block in index.blocks]
    head = json.dumps({"status": index.status, "blocks": blocks}).encode()
    return b"\n".join((head, index.frame))


def _decoded(data: bytes) -> Index:
    head, _, frame = data.partition(b"\n")
    found = json.loads(head)
    blocks = [Block(ranges, text.encode()) for text, *ranges in found["blocks"]]
    return Index(found["status"], frame, blocks)
